#include "core/control/control_quality.h"

#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr double kSettledShare = 0.05;
constexpr double kSteadyShare = 0.25;

}  // namespace

ControlQuality QualityOf(const SpeedReference& reference, const ControlledStretch& stretch) {
  const std::size_t end = std::min(stretch.reference_rad_s.size(), stretch.speed_rad_s.size());
  LAB_CHECK(stretch.control_from <= stretch.from, stretch.from);
  const std::size_t begin = stretch.from;
  const std::size_t hold = ReferencePlayer(reference, stretch.period_s).hold_ticks();
  const double height = reference.height();
  const bool holds = reference.shape != SpeedReference::Shape::kRamp;
  ControlQuality quality;
  std::size_t last_out = 0;
  double steady_sum = 0.0;
  std::size_t steady = 0;
  std::size_t last_step = begin;
  for (std::size_t k = begin; k < end; ++k) {
    const double wanted = stretch.reference_rad_s[k];
    const double error = wanted - stretch.speed_rad_s[k];
    if (!std::isfinite(error)) continue;
    quality.iae_rad += std::abs(error) * stretch.period_s;
    if (k >= begin + 2 * hold) quality.late_iae_rad += std::abs(error) * stretch.period_s;
    if (!holds) continue;
    const std::size_t in_hold = (k - stretch.control_from) % hold;
    if (in_hold == 0) last_step = k;
    const bool up = wanted == reference.highest();
    const double beyond = up ? -error : error;
    if (k >= begin + hold && height > 0.0) {
      quality.overshoot_percent = std::max(quality.overshoot_percent, 100.0 * beyond / height);
    }
    if (std::abs(error) > kSettledShare * std::max(height, 1.0)) last_out = k;
    if (static_cast<double>(in_hold) >= (1.0 - kSteadyShare) * static_cast<double>(hold)) {
      steady_sum += error;
      ++steady;
    }
    if (in_hold + 1 == hold && steady > 0) {
      const double mean = std::abs(steady_sum / static_cast<double>(steady));
      quality.steady_error_rad_s = std::max(quality.steady_error_rad_s, mean);
      steady_sum = 0.0;
      steady = 0;
    }
  }
  if (holds && last_out + 1 < end) {
    const std::size_t from = std::max(last_step, begin);
    quality.settling_s =
        last_out < from ? 0.0 : static_cast<double>(last_out + 1 - from) * stretch.period_s;
  }
  return quality;
}

}  // namespace faultlab::core
