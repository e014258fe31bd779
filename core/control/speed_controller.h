#pragma once

#include "core/control/speed_model.h"

namespace faultlab::core {

/// PI control of the speed, v = kp e + ki integral of e, for the plant that it was tuned for. What
/// the drive could not give does not wind up the integral (back calculation).
class SpeedController {
 public:
  /// The integral cancels the pole of the plant; the closed loop is `faster` times as fast as the
  /// plant, slower where that is too fast for its period.
  SpeedController(const SpeedModel& plant, double period_s, double faster);

  /// The input that the controller asks for; until Applied is called it counts as applied.
  double Step(double reference_rad_s, double speed_rad_s);
  /// What became of the last Step's input: the integral is moved so that it would have asked for
  /// this.
  void Applied(double input_v);

  double kp() const { return kp_; }
  double ki() const { return ki_; }

 private:
  double kp_;  ///< V per rad/s
  double ki_;  ///< V per rad/s and s
  double period_s_;
  double integral_v_ = 0.0;
  double error_rad_s_ = 0.0;
};

}  // namespace faultlab::core
