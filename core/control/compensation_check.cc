#include "core/control/compensation_check.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

// A prediction is drawn to the reading by this share of its model's own pace: friction's slow part
// counts less, a wrong gain the same whatever the time constant.
constexpr double kDrawn = 0.3;
// What one state leaves of a speed: the inductance, friction's slow part, the value's own error.
constexpr double kModelShare = 0.02;
// The same of a speed behind a lag, as a share of it.
constexpr double kLagShare = 0.1;
// A diagnosis must leave less than half of what no diagnosis leaves, or next to nothing.
constexpr double kLeftMax = 0.5;
constexpr double kNothing = 0.25;
// Well beyond chance: what one state lacks at a switch-over must not do it.
constexpr double kRefuted = 20.0;

}  // namespace

CompensationCheck::CompensationCheck(const SpeedModel& healthy,
                                     const SpeedModel& believed,
                                     double speed_rad_s,
                                     double noise_rad_s,
                                     double lag_share)
    : healthy_(healthy),
      believed_(believed),
      healthy_rad_s_(speed_rad_s),
      believed_rad_s_(speed_rad_s),
      noise_rad_s_(noise_rad_s),
      model_share_(kModelShare + kLagShare * lag_share) {}

bool CompensationCheck::Push(double speed_rad_s, double u_v) {
  healthy_rad_s_ = healthy_.Next(healthy_rad_s_, u_v);
  believed_rad_s_ = believed_.Next(believed_rad_s_, u_v);
  if (sum_ < kRefuted && std::isfinite(speed_rad_s)) {
    const double healthy_error = speed_rad_s - healthy_rad_s_;
    const double believed_error = speed_rad_s - believed_rad_s_;
    const double model_rad_s = model_share_ * speed_rad_s;
    const double variance = noise_rad_s_ * noise_rad_s_ + model_rad_s * model_rad_s;
    const double allowed = kLeftMax * healthy_error;
    const double more = believed_error * believed_error - allowed * allowed;
    sum_ = std::max(0.0, sum_ + 0.5 * more / std::max(variance, 1e-12) - kNothing);
    healthy_rad_s_ += kDrawn * (1.0 - healthy_.kept) * healthy_error;
    believed_rad_s_ += kDrawn * (1.0 - believed_.kept) * believed_error;
  }
  return sum_ >= kRefuted;
}

}  // namespace faultlab::core
