#pragma once

#include "core/control/speed_model.h"

namespace faultlab::core {

/// Stands between a controller that was tuned for the healthy rig and a rig with a fault: gives the
/// rig the input under which its next speed is the one that the healthy rig would have had,
///   kept' w + (1 - kept') (gain' u - friction') = kept w + (1 - kept) (gain v - friction)
/// so that the controller meets the healthy rig again. Without a fault u = v. Of a fault that makes
/// the amplifier slow, what the lag holds is known, and is made up for as well (a lead).
///
/// Stability, a sketch: let the rig be (kept', gain'), the diagnosis (kept_d, gain_d), and
/// m = (1 - kept') gain' / ((1 - kept_d) gain_d). Then
///   w+ = Next(w, v) + e,   e = (m - 1) (Next(w, v) - kept_d w) + (kept' - kept_d) w + constant
/// The healthy PI loop, whose integral cancels the pole, answers e with a gain of at most
/// 1 / (1 - kept) at any frequency and 0 at low ones: by the small gain theorem it stays stable
/// while |m - 1| (1 - kept_d) + |kept' - kept_d| < 1 - kept, and the constant is taken up. That is
/// sufficient, not necessary: 1 000 random rigs with values off by up to 40 % are stable
/// (speed_model_test).
///
/// Source: J. Lunze, T. Steffen, Control reconfiguration after actuator failures using disturbance
/// decoupling methods, IEEE Trans. Automatic Control 51 (2006), pp. 1590-1601.
class VirtualActuator {
 public:
  explicit VirtualActuator(const SpeedModel& healthy) : healthy_(healthy), rig_{.motor = healthy} {}

  void Reconfigure(const LaggedModel& faulty) {
    compensates_ = true;
    rig_ = faulty;
  }
  /// The rig is healthy again, or the diagnosis was withdrawn.
  void Withdraw() { compensates_ = false; }
  bool compensates() const { return compensates_; }

  /// The rig's input for the controller's.
  /// @param lag_v  state of the rig's lag
  double RigInput(double v, double w_rad_s, double lag_v) const {
    if (!compensates_) return v;
    return rig_.InputFor(rig_.motor.InputFor(w_rad_s, healthy_.Next(w_rad_s, v)), lag_v);
  }
  /// The controller's input that has this rig's input.
  double ControllerInput(double u, double w_rad_s, double lag_v) const {
    if (!compensates_) return u;
    return healthy_.InputFor(w_rad_s, rig_.motor.Next(w_rad_s, rig_.Handed(u, lag_v)));
  }

 private:
  SpeedModel healthy_;
  LaggedModel rig_;
  bool compensates_ = false;
};

}  // namespace faultlab::core
