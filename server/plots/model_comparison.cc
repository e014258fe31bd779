#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/plant/coefficients.h"
#include "core/plant/measured_gain.h"
#include "core/plant/model_fit.h"
#include "core/plant/sampled_model.h"
#include "core/types/number_text.h"
#include "core/types/sample_intake.h"
#include "server/plots/record_figure.h"

namespace faultlab::server {
namespace {

/// Of a record that is faster than its bench's delta: the models read before the next edge.
constexpr double kDeltaShareMax = 0.99;
constexpr double kStretchSecondsMin = 2.0;
constexpr double kStretchSecondsMax = 10.0;  // as the paper's: from the fault at 10 s to 20 s

struct Stretch {
  std::vector<double> t_s, uc_v, y;
};

/// From the newest change (or the middle of the record) to its end, at most kStretchSecondsMax,
/// without a gap and without a lost reading; of several such pieces the last.
Stretch FindStretch(std::span<const core::Sample> samples,
                    core::EstimatedChannel channel,
                    bool of_row_before,
                    double from_s,
                    double period_s) {
  std::size_t begin = 0;
  std::size_t best_begin = 0;
  std::size_t best_end = 0;
  const auto usable = [&](std::size_t k) {
    return samples[k].t_s >= from_s && std::isfinite(samples[k].uc_v) &&
           std::isfinite(core::ReadingOf(samples[k], channel));
  };
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (!usable(k)) {
      begin = k + 1;
      continue;
    }
    if (k > 0 && samples[k].index != samples[k - 1].index + 1) {
      begin = k;
    }
    if (static_cast<double>(k + 1 - begin) * period_s >= kStretchSecondsMin) {
      best_begin = begin;
      best_end = k + 1;
    }
  }
  const auto most = static_cast<std::size_t>(kStretchSecondsMax / period_s);
  best_end = std::min(best_end, best_begin + most);
  Stretch stretch;
  for (std::size_t k = best_begin; k < best_end; ++k) {
    stretch.t_s.push_back(samples[k].t_s);
    stretch.uc_v.push_back(samples[of_row_before && k > best_begin ? k - 1 : k].uc_v);
    stretch.y.push_back(core::ReadingOf(samples[k], channel));
  }
  return stretch;
}

bool IsUsable(const core::Estimate<3>& estimate) {
  return estimate.status == core::EstimateStatus::kExcited ||
         estimate.status == core::EstimateStatus::kWeak;
}

}  // namespace

ModelComparison CompareModels(std::span<const core::Sample> samples,
                              const core::DiagnosisOptions& options,
                              const core::Diagnosis& diagnosis) {
  ModelComparison comparison;
  comparison.channel = options.bench->structure->estimated;
  if (samples.empty()) {
    return comparison;
  }
  const core::Verdict& verdict = diagnosis.verdict;
  const double middle = 0.5 * (samples.front().t_s + samples.back().t_s);
  const double from_s = core::NewestChange(diagnosis).value_or(middle);
  Stretch stretch = FindStretch(
      samples, comparison.channel, options.bench->follows_row_before(), from_s, options.period_s);
  comparison.t_s = stretch.t_s;
  comparison.y = stretch.y;
  if (stretch.t_s.empty()) {
    return comparison;
  }
  const auto add = [&](const std::string& key, const std::string& name, core::ModelFit fit) {
    comparison.models.push_back({key, name, fit.fit_percent, std::move(fit.simulated)});
  };
  const double delta_s =
      diagnosis.calibration
          ? diagnosis.calibration->delta_s
          : std::min(options.bench->ReadingDelay(options.bench->delta_s, options.period_s),
                     kDeltaShareMax * options.period_s);
  const auto estimate = [&](core::EstimatorId id) -> const core::Estimate<3>& {
    return diagnosis.estimates[static_cast<std::size_t>(id)];
  };
  const core::Estimate<3>& swa = estimate(core::EstimatorId::kSwa100);
  if (IsUsable(swa)) {
    add("swa",
        "SWA",
        core::FitDiscrete({swa.theta[0], swa.theta[1], swa.theta[2]}, stretch.uc_v, stretch.y));
  }
  const core::Estimate<3>& sia = estimate(core::EstimatorId::kSia100x20);
  if (IsUsable(sia) && sia.theta[2] > 0.0) {
    const core::ContinuousCoefficients model = {sia.theta[0], sia.theta[1], sia.theta[2], 0.0, 0.0};
    add("sia",
        "SIA",
        core::FitContinuous(model, stretch.uc_v, stretch.y, options.period_s, delta_s));
  }
  const bool fault = verdict.kind == core::VerdictKind::kFault && !verdict.candidates.empty();
  const auto with_fault = [&](core::PlantParameters plant) {
    if (fault) {
      plant.Set(verdict.candidates.front().component, verdict.candidates.front().value);
    }
    return plant;
  };
  const core::ContinuousCoefficients eq3 = core::MakeContinuous(with_fault(options.nominal));
  std::vector<double> frictions_nm = {0.0};
  const std::vector<double>& published = options.bench->published.mc_nm;
  frictions_nm.insert(frictions_nm.end(), published.begin(), published.end());
  if (published.empty()) frictions_nm.push_back(options.bench->norm.mc_nm);
  const core::SampledModel sampled =
      core::MakeSampledModel(with_fault(options.nominal), options.period_s, delta_s);
  for (const double mc_nm : frictions_nm) {
    const std::string mc = core::Format("%.3g", 1e3 * mc_nm);
    add(std::string("model_mc_") + mc + (mc_nm == 0.0 ? "" : "mNm"),
        std::string("M_{c} ") + mc + " mNm",
        core::FitFriction(eq3,
                          mc_nm,
                          stretch.uc_v,
                          stretch.y,
                          options.period_s,
                          delta_s,
                          core::FrictionDirections(sampled, stretch.uc_v, mc_nm)));
  }
  if (diagnosis.calibration) {
    const core::Calibration& calibration = *diagnosis.calibration;
    const core::PlantParameters plant = core::WithMeasuredGain(
        with_fault(core::WithMeasuredLag(calibration.nominal, calibration.lag_factor)),
        calibration.gain_factor);
    const double unit = core::ReadingPerOutput(plant);
    std::vector<double> output;
    for (const double reading : stretch.y) output.push_back(reading / unit);
    core::ModelFit fit = core::FitSampled(core::MakeSampledModel(plant, options.period_s, delta_s),
                                          core::InfoOf(comparison.channel).row,
                                          calibration.mc_nm,
                                          stretch.uc_v,
                                          output);
    for (double& value : fit.simulated) value *= unit;
    add("faultlab", "faultlab", std::move(fit));
  }
  return comparison;
}

void AddModelFits(std::span<const core::Sample> samples,
                  const core::DiagnosisOptions& options,
                  core::Diagnosis& diagnosis) {
  for (const ModelOutput& model : CompareModels(samples, options, diagnosis).models) {
    diagnosis.fit_percent.push_back({model.key, model.fit_percent});
  }
}

}  // namespace faultlab::server
