#include "core/filter/observation.h"

#include <cmath>

#include "core/filter/rig_parameters.h"

namespace faultlab::core {
bool ObservationBuilder::Push(const Sample& sample, Observation& out) {
  if (!std::isfinite(sample.uc_v) || !std::isfinite(sample.t_s)) return false;
  const SampleStep step = intake_.Classify(sample);
  if (step.use == SampleUse::kIgnore) return false;
  out.restart = !has_last_ || step.missing > 0;
  out.u_prev = out.restart ? sample.uc_v : last_u_;
  out.u = sample.uc_v;
  out.y = {sample.um_v, sample.ia_a, sample.n_rpm * rad_per_s_of_rpm_};
  out.mask = 0;
  const int usable = channels_ == Channels::kAll ? kOutputCount : 1;
  for (int c = 0; c < kOutputCount; ++c) {
    double& y = out.y[static_cast<std::size_t>(c)];
    if (c < usable && std::isfinite(y) && (c != 1 || ia_.Holds(y))) {
      out.mask = static_cast<std::uint8_t>(out.mask | (1U << c));
    } else {
      y = 0.0;
    }
  }
  out.clipped = 0;
  if (step.use == SampleUse::kClipped) out.clipped = out.y[0] > 0.0 ? 1 : -1;
  last_u_ = sample.uc_v;
  has_last_ = true;
  return true;
}

std::vector<Observation> MakeObservations(std::span<const Sample> samples,
                                          Channels channels,
                                          double period_s,
                                          double um_rail_v,
                                          double gear_ratio,
                                          const ReadingRange& ia) {
  ObservationBuilder builder(channels, period_s, um_rail_v, gear_ratio, ia);
  std::vector<Observation> observations;
  observations.reserve(samples.size());
  Observation next;
  for (const Sample& sample : samples) {
    if (builder.Push(sample, next)) observations.push_back(next);
  }
  return observations;
}

}  // namespace faultlab::core
