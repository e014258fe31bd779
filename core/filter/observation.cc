#include "core/filter/observation.h"

#include <cmath>
#include <limits>

#include "core/filter/rig_parameters.h"

namespace faultlab::core {
namespace {

unsigned ChannelsOf(const ReadingRules& rules, Channels channels) {
  const unsigned described =
      (rules.has_um ? 1U : 0U) | (rules.has_ia ? 2U : 0U) | (rules.has_n ? 4U : 0U);
  return channels == Channels::kAll ? described : described & 1U;
}

}  // namespace

ReadingErrors ErrorsOf(const Calibration& calibration) {
  return {{calibration.um_zero_v,
           calibration.ia_zero_a,
           calibration.n_zero_rpm * RadPerSecondOfRpm(calibration.nominal.gear_ratio)},
          calibration.model_error};
}

void ReadingTrust::Give(Observation& observation) {
  if (error_.step_v <= 0.0) return;
  const std::size_t age = age_.Push(observation.u - observation.u_prev, error_.step_v);
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    observation.trust[c] = 1.0 / error_.growth[c][age];
  }
}

void GiveTrust(const ModelError& error, double period_s, std::span<Observation> stretch) {
  ReadingTrust trust(error, period_s);
  for (Observation& o : stretch) trust.Give(o);
}

ObservationBuilder::ObservationBuilder(const ReadingRules& rules,
                                       Channels channels,
                                       double period_s,
                                       double um_rail_v,
                                       const ReadingErrors& errors)
    : rules_(rules),
      channels_(ChannelsOf(rules, channels)),
      rad_per_s_of_rpm_(RadPerSecondOfRpm(rules.gear_ratio)),
      zeros_(errors.zeros),
      trust_(errors.left, period_s),
      intake_(period_s, rules.has_um ? um_rail_v : std::numeric_limits<double>::infinity()),
      kept_(std::exp(-0.5 * period_s / rules.speed_time_constant_s)) {}

// A motor that should turn much faster than the floor is not passing through rest: it is held, or
// its speed is not read.
bool ObservationBuilder::IsRead(std::size_t channel, double y) const {
  constexpr double kMuchFaster = 2.0;
  if (channel == 0) return true;
  if (channel == 1) return rules_.ia.Holds(y);
  const double expected = expected_rad_s_ * settled_rad_s_ > 0.0 ? std::abs(expected_rad_s_) : 0.0;
  return std::abs(y) >= rules_.speed_floor_rad_s ||
         expected - rules_.speed_friction_rad_s > kMuchFaster * rules_.speed_floor_rad_s;
}

bool ObservationBuilder::Push(const Sample& sample, Observation& out) {
  if (!std::isfinite(sample.uc_v) || !std::isfinite(sample.t_s)) return false;
  const SampleStep step = intake_.Classify(sample);
  if (step.use == SampleUse::kIgnore) return false;
  out.restart = !has_last_ || step.missing > 0;
  // After a gap nothing is known of the row before, nor when the pulses were counted.
  const bool unknown = rules_.of_row_before && out.restart;
  out.u_prev = out.restart ? sample.uc_v : used_u_;
  out.u = rules_.of_row_before && !out.restart ? last_u_ : sample.uc_v;
  out.y = {sample.um_v, sample.ia_a, sample.n_rpm * rad_per_s_of_rpm_};
  out.mask = 0;
  settled_rad_s_ = rules_.speed_per_v * out.u_prev;
  expected_rad_s_ = out.restart ? 0.0 : settled_rad_s_ + kept_ * (expected_rad_s_ - settled_rad_s_);
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    double& y = out.y[c];
    if (((channels_ >> c) & 1U) != 0U && std::isfinite(y) && IsRead(c, y) && !unknown) {
      out.mask = static_cast<std::uint8_t>(out.mask | (1U << c));
      y -= zeros_[c];
    } else {
      y = 0.0;
    }
  }
  out.clipped = 0;
  if (step.use == SampleUse::kClipped) out.clipped = out.y[0] > 0.0 ? 1 : -1;
  trust_.Give(out);
  last_u_ = sample.uc_v;
  used_u_ = out.u;
  has_last_ = true;
  return true;
}

std::vector<Observation> MakeObservations(std::span<const Sample> samples,
                                          const ReadingRules& rules,
                                          Channels channels,
                                          double period_s,
                                          double um_rail_v,
                                          const ReadingErrors& errors,
                                          std::vector<double>* t_s) {
  ObservationBuilder builder(rules, channels, period_s, um_rail_v, errors);
  std::vector<Observation> observations;
  observations.reserve(samples.size());
  Observation next;
  for (const Sample& sample : samples) {
    if (!builder.Push(sample, next)) continue;
    observations.push_back(next);
    if (t_s != nullptr) t_s->push_back(sample.t_s);
  }
  return observations;
}

}  // namespace faultlab::core
