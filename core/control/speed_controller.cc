#include "core/control/speed_controller.h"

#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {

SpeedController::SpeedController(const SpeedModel& plant, double period_s, double faster)
    : kp_(faster / plant.gain), ki_(0.0), period_s_(period_s) {
  LAB_CHECK(faster > 0.0 && plant.kept > 0.0 && plant.kept < 1.0, faster, plant.kept);
  const double time_constant_s = -period_s / std::log(plant.kept);
  ki_ = kp_ / time_constant_s;
}

double SpeedController::Step(double reference_rad_s, double speed_rad_s) {
  error_rad_s_ = reference_rad_s - speed_rad_s;
  integral_v_ += ki_ * period_s_ * error_rad_s_;
  return kp_ * error_rad_s_ + integral_v_;
}

void SpeedController::Applied(double input_v) {
  integral_v_ = input_v - kp_ * error_rad_s_;
}

}  // namespace faultlab::core
