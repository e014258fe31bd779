#include "server/demonstration/estimate_study.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/plant/coefficients.h"
#include "core/signals/random.h"
#include "server/demonstration/demonstration.h"

namespace faultlab::server {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kNoiseSeed = 11;
/// The rig starts from rest: what comes before is no steady operation.
constexpr std::size_t kStartUp = 50;
constexpr double kWay = 0.9;
/// A smaller change is not one that a delay can be read from.
constexpr double kDeviationsSeen = 5.0;

core::Error Outside(const std::string& member, int lowest, int highest) {
  return core::Refuse("whole_number_outside",
                      member,
                      {{"member", member}, {"lowest", lowest}, {"highest", highest}});
}

struct Moments {
  double mean = kNan;
  double deviation = kNan;
};

Moments MomentsOf(std::span<const double> values) {
  double sum = 0.0;
  double square = 0.0;
  double count = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    count += 1.0;
    const double step = value - sum;  // Welford: no difference of large sums
    sum += step / count;
    square += step * (value - sum);
  }
  if (count < 2.0) return {};
  return {sum, std::sqrt(square / (count - 1.0))};
}

/// @returns the rms of the noise that was added
double AddNoise(Demonstration& played, core::EstimatedChannel channel, double percent) {
  std::vector<double> healthy;
  for (std::size_t i = kStartUp; i < played.fault_at; ++i) {
    healthy.push_back(core::ReadingOf(played.samples[i], channel));
  }
  const double rms = percent / 100.0 * MomentsOf(healthy).deviation;
  core::Random random(kNoiseSeed);
  for (core::Sample& sample : played.samples)
    core::ReadingOf(sample, channel) += rms * random.Normal();
  return rms;
}

std::array<double, 3> ModelOf(const core::PlantParameters& plant,
                              const core::Bench& bench,
                              core::EstimatorMethod method) {
  const core::ContinuousCoefficients model = core::MakeContinuous(plant);
  if (method == core::EstimatorMethod::kSia) return {model.b0, model.b1, model.a1};
  const auto discrete = core::Discretise(model, bench.period_s, bench.profiles.front().delta_s);
  return {discrete.b0d, discrete.b1d, discrete.a1d};
}

void Judge(EstimateStudy::Parameter& parameter,
           std::size_t full_at,
           std::size_t fault_at,
           double period_s) {
  const std::span<const double> all(parameter.estimates);
  const std::size_t first = std::min(kStartUp + full_at, fault_at);
  const Moments healthy = MomentsOf(all.subspan(first, fault_at - first));
  parameter.mean = healthy.mean;
  parameter.deviation = healthy.deviation;
  const Moments after = MomentsOf(all.subspan(std::min(fault_at + full_at, all.size())));
  parameter.mean_after = after.mean;
  const double way = after.mean - healthy.mean;
  const double noise = std::max(healthy.deviation, after.deviation);
  if (!(std::abs(way) > kDeviationsSeen * noise)) return;
  for (std::size_t i = fault_at; i < all.size(); ++i) {
    if (!((all[i] - healthy.mean) / way >= kWay)) continue;
    parameter.delay_s = static_cast<double>(i - fault_at) * period_s;
    return;
  }
}

}  // namespace

core::Result<EstimateStudy> StudyEstimates(const core::Bench& bench,
                                           const EstimateQuestion& question) {
  TRY(auto played, PlayDemonstration(bench, question.changes, {}));
  const core::EstimatedChannel channel = bench.structure->estimated;
  EstimateStudy study;
  study.added_noise = AddNoise(played, channel, question.added_noise_percent);

  core::VariantSpec spec;
  spec.method = question.method;
  spec.window_samples = question.window_samples;
  spec.integral_samples = question.integral_samples;
  spec.sia_mode =
      question.method == core::EstimatorMethod::kSia ? question.sia_mode : core::SiaMode::kPaper;
  spec.delta_s = bench.profiles.front().delta_s;
  spec.period_s = bench.period_s;
  spec.channel = channel;
  auto estimator = core::MakeVariant(spec);
  if (!estimator) {
    const bool integral = estimator.error().field == "integral_samples";
    return Outside(integral ? "integral" : "window",
                   integral ? 1 : 2 * 3,
                   integral ? question.window_samples - 1 : kStudyWindowMax);
  }
  const auto names = core::ParameterNames(spec);
  const auto nominal = ModelOf(bench.nominal, bench, question.method);
  const auto changed = ModelOf(ChangedPlant(bench, question.changes), bench, question.method);
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    study.parameters[i].name = names[i];
    study.parameters[i].nominal = nominal[i];
    study.parameters[i].changed = changed[i];
    study.parameters[i].estimates.reserve(played.samples.size());
  }
  for (const core::Sample& sample : played.samples) {
    const core::VariantEstimate& estimate = estimator.value()->Push(sample);
    const bool usable = estimate.status != core::EstimateStatus::kInvalid &&
                        estimate.status != core::EstimateStatus::kNotExcited;
    for (std::size_t i = 0; i < study.parameters.size(); ++i) {
      study.parameters[i].estimates.push_back(usable ? estimate.theta[i] : kNan);
    }
  }
  const int filled = question.window_samples + question.integral_samples;
  for (EstimateStudy::Parameter& parameter : study.parameters) {
    Judge(parameter, static_cast<std::size_t>(filled), played.fault_at, bench.period_s);
  }
  study.fault_at_s = static_cast<double>(played.fault_at) * bench.period_s;
  study.settle_s = (filled - 1) * bench.period_s;
  return study;
}

}  // namespace faultlab::server
