#include "server/plots/record_figure.h"

#include "core/diagnosis/diagnose_record.h"
#include "core/paper/decisions.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace faultlab::server {
namespace {

/// Of each estimator of the family. Frames are not kept: they would need 500 bytes a sample.
std::vector<EstimateCurve> CurvesOf(std::span<const core::Sample> samples,
                                    const core::DiagnosisOptions& options,
                                    EstimatorFamily family) {
  const auto estimators = EstimatorsOf(family);
  std::vector<EstimateCurve> curves;
  for (const core::EstimatorId estimator : estimators) curves.push_back(EmptyCurve(estimator));
  core::ReplayEstimates(samples, options, [&](const core::Frame& frame) {
    for (std::size_t i = 0; i < curves.size(); ++i) Append(frame, estimators[i], curves[i]);
  });
  return curves;
}

void FillContext(const core::Diagnosis& diagnosis, FigureContext& context) {
  if (context.episodes.empty()) {
    context.episodes = core::EpisodesOf(diagnosis);
  }
  const auto nominal = [&](core::EstimatorId id) {
    return diagnosis.nominal_estimates[static_cast<std::size_t>(id)];
  };
  if (!context.nominal_swa) {
    context.nominal_swa = nominal(core::EstimatorId::kSwa100);
  }
  if (!context.nominal_sia) {
    context.nominal_sia = nominal(core::EstimatorId::kSia100x20);
  }
}

}  // namespace

std::string FigureList() {
  std::string list;
  for (const std::string_view name : kFigureNames) {
    list.append(list.empty() ? "" : ", ").append(name);
  }
  return list;
}

core::Status CheckFigure(std::string_view name, std::span<const core::Sample> samples) {
  const bool known = std::ranges::find(kFigureNames, name) != std::end(kFigureNames);
  if (!known) {
    return core::Error{
        core::ErrorCode::kNotFound,
        "unknown figure '" + std::string(name) + "', expected one of " + FigureList(),
        "figure",
        "no_figure"};
  }
  if (samples.size() < 2) {
    return core::Refuse("figure_needs_samples", "samples");
  }
  return core::Done{};
}

core::Result<Figure> MakeFigure(std::string_view name,
                                std::span<const core::Sample> samples,
                                const core::DiagnosisOptions& options,
                                FigureContext context) {
  TRY_DONE(CheckFigure(name, samples));
  return MakeFigure(
      name, samples, options, core::DiagnoseRecord(samples, options), std::move(context));
}

core::Result<Figure> MakeFigure(std::string_view name,
                                std::span<const core::Sample> samples,
                                const core::DiagnosisOptions& options,
                                const core::Diagnosis& diagnosis,
                                FigureContext context) {
  TRY_DONE(CheckFigure(name, samples));
  FillContext(diagnosis, context);
  context.estimated = options.bench->structure->estimated;
  context.friction = options.bench->profiles.front().friction;
  if (name == "signals") {
    return MakeSignalsFigure(samples, context);
  }
  if (name == "swa" || name == "sia") {
    const EstimatorFamily family = name == "swa" ? EstimatorFamily::kSwa : EstimatorFamily::kSia;
    return MakeCurvesFigure(CurvesOf(samples, options, family), family, context);
  }
  if (name == "friction") {
    if (!diagnosis.calibration) return core::Refuse("figure_needs_calibration", "samples");
    return MakeFrictionFigure(samples, diagnosis, context);
  }
  if (name == "steps" || name == "decisions") {
    if (!core::HasDecisions(*options.bench))
      return core::Refuse("figure_needs_decisions", "figure");
    if (name == "steps") return MakeStepsFigure(diagnosis, context);
    return MakeDecisionsFigure(*options.bench, diagnosis, context);
  }
  const ModelComparison comparison = CompareModels(samples, options, diagnosis);
  if (comparison.t_s.empty()) {
    return core::Refuse("figure_needs_span", "samples");
  }
  return MakeModelsFigure(comparison, context);
}

}  // namespace faultlab::server
