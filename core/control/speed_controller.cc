#include "core/control/speed_controller.h"

#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

// What a period makes of an error, as a share of it: stable with a period's delay up to 1.
constexpr double kLoopMax = 0.5;

}  // namespace

SpeedController::SpeedController(const SpeedModel& plant, double period_s, double faster)
    : kp_(faster / plant.gain), ki_(0.0), period_s_(period_s) {
  LAB_CHECK(faster > 0.0 && plant.kept > 0.0 && plant.kept < 1.0, faster, plant.kept);
  const double time_constant_s = -period_s / std::log(plant.kept);
  ki_ = kp_ / time_constant_s;
  // Of a plant that settles within a period, whose reading may still be of the input before.
  const double loop = (kp_ + ki_ * period_s) * plant.gain * (1.0 - plant.kept);
  if (loop <= kLoopMax) return;
  kp_ *= kLoopMax / loop;
  ki_ *= kLoopMax / loop;
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
