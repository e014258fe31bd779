#include "core/filter/observation.h"

#include <cmath>

#include "core/filter/rig_parameters.h"

namespace faultlab::core {
namespace {

// A 16-bit converter of +-10 V has steps of 0.3 mV: within three of them of its end it is clipped.
constexpr double kRailMarginV = 1e-3;

}  // namespace

bool ObservationBuilder::Push(const Sample& sample, Observation& out) {
  if (!std::isfinite(sample.uc_v) || !std::isfinite(sample.t_s)) return false;
  const double steps = (sample.t_s - last_t_s_) / period_s_;
  if (has_last_ && steps < 0.5) return false;
  out.restart = !has_last_ || steps > 1.5;
  out.u_prev = out.restart ? sample.uc_v : last_u_;
  out.u = sample.uc_v;
  out.y = {sample.um_v, sample.ia_a, sample.n_rpm * kRadPerSecondOfRpm};
  out.mask = 0;
  const int usable = channels_ == Channels::kAll ? kOutputCount : 1;
  for (int c = 0; c < kOutputCount; ++c) {
    double& y = out.y[static_cast<std::size_t>(c)];
    if (c < usable && std::isfinite(y)) {
      out.mask = static_cast<std::uint8_t>(out.mask | (1U << c));
    } else {
      y = 0.0;
    }
  }
  out.clipped = 0;
  if ((out.mask & 1U) != 0U && std::abs(out.y[0]) >= um_rail_v_ - kRailMarginV) {
    out.clipped = out.y[0] > 0.0 ? 1 : -1;
  }
  last_t_s_ = sample.t_s;
  last_u_ = sample.uc_v;
  has_last_ = true;
  return true;
}

std::vector<Observation> MakeObservations(std::span<const Sample> samples,
                                          Channels channels,
                                          double period_s,
                                          double um_rail_v) {
  ObservationBuilder builder(channels, period_s, um_rail_v);
  std::vector<Observation> observations;
  observations.reserve(samples.size());
  Observation next;
  for (const Sample& sample : samples) {
    if (builder.Push(sample, next)) observations.push_back(next);
  }
  return observations;
}

}  // namespace faultlab::core
