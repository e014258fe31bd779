#include "core/control/compensation_check.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

// A prediction is drawn to the reading by this share of its model's own pace: friction's slow part
// counts less, a wrong gain the same whatever the time constant.
constexpr double kDrawn = 0.3;
// What the model leaves of a speed: the inductance, the value's own error; and of the speed that
// friction takes, since friction wanders.
constexpr double kModelShare = 0.02;
constexpr double kFrictionShare = 0.1;
// A diagnosis must leave less than this share of what no diagnosis leaves, or next to nothing.
constexpr double kLeftMax = 0.3;
constexpr double kNothing = 0.25;
// Well beyond chance: what one state lacks at a switch-over must not do it.
constexpr double kRefuted = 20.0;

}  // namespace

/// What the lag held before the first reading is not known: a switched capacitor is empty.
void CompensationCheck::Racer::Begin(double reading_rad_s, double u_v) {
  const double share = model.LagShare();
  if (share == 0.0) return;
  const double handed_v = model.motor.InputFor(speed_rad_s, reading_rad_s);
  lag_v = u_v + (handed_v - u_v) / share;
}

void CompensationCheck::Racer::Predict(double u_v) {
  speed_rad_s = model.motor.Next(speed_rad_s, model.Handed(u_v, lag_v));
  lag_v = model.LagNext(lag_v, u_v);
}

CompensationCheck::CompensationCheck(const LaggedModel& healthy,
                                     const LaggedModel& believed,
                                     double speed_rad_s,
                                     double input_v,
                                     double noise_rad_s)
    : healthy_{healthy, input_v, speed_rad_s},
      believed_{believed, input_v, speed_rad_s},
      noise_rad_s_(noise_rad_s) {}

bool CompensationCheck::Push(double speed_rad_s, double u_v) {
  if (!begun_ && std::isfinite(speed_rad_s)) {
    begun_ = true;
    healthy_.Begin(speed_rad_s, u_v);
    believed_.Begin(speed_rad_s, u_v);
  }
  healthy_.Predict(u_v);
  believed_.Predict(u_v);
  if (sum_ < kRefuted && std::isfinite(speed_rad_s)) {
    const double healthy_error = speed_rad_s - healthy_.speed_rad_s;
    const double believed_error = speed_rad_s - believed_.speed_rad_s;
    const double model_rad_s = kModelShare * speed_rad_s;
    const double friction_rad_s = kFrictionShare * believed_.model.motor.friction;
    const double variance =
        noise_rad_s_ * noise_rad_s_ + model_rad_s * model_rad_s + friction_rad_s * friction_rad_s;
    const double allowed = kLeftMax * healthy_error;
    const double more = believed_error * believed_error - allowed * allowed;
    sum_ = std::max(0.0, sum_ + 0.5 * more / std::max(variance, 1e-12) - kNothing);
    healthy_.speed_rad_s += kDrawn * (1.0 - healthy_.model.motor.kept) * healthy_error;
    believed_.speed_rad_s += kDrawn * (1.0 - believed_.model.motor.kept) * believed_error;
  }
  return sum_ >= kRefuted;
}

}  // namespace faultlab::core
