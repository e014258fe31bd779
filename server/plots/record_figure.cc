#include "server/plots/record_figure.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "core/diagnosis/pipeline.h"

namespace faultlab::server {
namespace {

core::PipelineConfig ConfigOf(const core::DiagnoseOptions& options) {
  core::PipelineConfig config;
  config.nominal = options.nominal;
  config.calibration = options.calibration;
  config.healthy_from_s = options.healthy_from_s;
  config.healthy_to_s = options.healthy_to_s;
  config.channels = options.channels;
  config.values = options.values;
  config.motor_faults = options.motor_faults;
  config.period_s = options.period_s;
  config.false_alarms_per_day = options.false_alarms_per_day;
  return config;
}

std::vector<core::Frame> Replay(std::span<const core::Sample> samples,
                                const core::DiagnoseOptions& options) {
  core::Pipeline pipeline(ConfigOf(options));
  std::vector<core::Frame> frames;
  frames.reserve(samples.size());
  for (const core::Sample& sample : samples) {
    frames.push_back(pipeline.Push(sample));
  }
  return frames;
}

void FillContext(const core::Diagnosis& diagnosis, FigureContext& context) {
  if (!context.verdict) {
    context.verdict = diagnosis.verdict;
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

core::Status CheckFigure(std::string_view name, std::span<const core::Sample> samples) {
  const bool known =
      std::find(std::begin(kFigureNames), std::end(kFigureNames), name) != std::end(kFigureNames);
  if (!known) {
    return core::Error{
        core::ErrorCode::kNotFound,
        "unknown figure '" + std::string(name) + "', expected one of signals, swa, sia, models",
        "figure"};
  }
  if (samples.size() < 2) {
    return core::Error{core::ErrorCode::kInvalid, "a figure needs at least two samples", "samples"};
  }
  return core::Done{};
}

core::Result<Figure> MakeFigure(std::string_view name,
                                std::span<const core::Sample> samples,
                                const core::DiagnoseOptions& options,
                                FigureContext context) {
  const core::Status fit = CheckFigure(name, samples);
  if (!fit.ok()) return fit.error();
  return MakeFigure(
      name, samples, options, core::DiagnoseRecord(samples, options), std::move(context));
}

core::Result<Figure> MakeFigure(std::string_view name,
                                std::span<const core::Sample> samples,
                                const core::DiagnoseOptions& options,
                                const core::Diagnosis& diagnosis,
                                FigureContext context) {
  const core::Status fit = CheckFigure(name, samples);
  if (!fit.ok()) return fit.error();
  FillContext(diagnosis, context);
  if (name == "signals") {
    return MakeSignalsFigure(samples, context);
  }
  if (name == "swa" || name == "sia") {
    const EstimatorFamily family = name == "swa" ? EstimatorFamily::kSwa : EstimatorFamily::kSia;
    return MakeEstimatesFigure(Replay(samples, options), family, context);
  }
  const ModelComparison comparison = CompareModels(samples, options, diagnosis);
  if (comparison.t_s.empty()) {
    return core::Error{core::ErrorCode::kInvalid,
                       "the models need 2 s without a gap behind the fault; the recording has none",
                       "samples"};
  }
  return MakeModelsFigure(comparison, context);
}

}  // namespace faultlab::server
