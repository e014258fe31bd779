#pragma once

#include <optional>

#include "core/control/speed_model.h"

namespace faultlab::core {

/// Stands between a controller that was tuned for the healthy rig and a rig with a fault: gives the
/// rig the input under which its next speed is the one that the healthy rig would have had,
///   kept' w + (1 - kept') (gain' u - friction') = kept w + (1 - kept) (gain v - friction)
/// so that the controller meets the healthy rig again. Without a fault u = v.
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
  explicit VirtualActuator(const SpeedModel& healthy) : healthy_(healthy), rig_(healthy) {}

  /// nullopt: the rig is healthy again, or the diagnosis was withdrawn.
  void Reconfigure(const std::optional<SpeedModel>& faulty) {
    compensates_ = faulty.has_value();
    rig_ = faulty.value_or(healthy_);
  }
  bool compensates() const { return compensates_; }

  /// The rig's input for the controller's.
  double RigInput(double v, double w_rad_s) const {
    return compensates_ ? rig_.InputFor(w_rad_s, healthy_.Next(w_rad_s, v)) : v;
  }
  /// The controller's input that has this rig's input.
  double ControllerInput(double u, double w_rad_s) const {
    return compensates_ ? healthy_.InputFor(w_rad_s, rig_.Next(w_rad_s, u)) : u;
  }

 private:
  SpeedModel healthy_;
  SpeedModel rig_;
  bool compensates_ = false;
};

}  // namespace faultlab::core
