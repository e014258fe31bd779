#pragma once

#include <optional>

#include "core/control/speed_model.h"

namespace faultlab::core {

/// Stands between a controller that was tuned for the healthy rig and a rig with a fault: gives the
/// rig the input under which its next speed is the one that the healthy rig would have had,
///   kept' w + (1 - kept') (gain' u - friction') = kept w + (1 - kept) (gain v - friction)
/// so that the controller meets the healthy rig again. Without a fault u = v.
///
/// Stability: with a diagnosis that is off by factors g of the gain and t of (1 - kept'), the loop
/// that remains is w+ = kept w + (1 - kept) m gain v + (kept - kept_)(..), m = g t. The healthy
/// loop w+ = kept w + (1 - kept) gain v under PI control has a gain margin well above 2 for
/// `faster` < 1; errors within the stated interval of the value move m by less, and the integral
/// takes up what is constant (small gain: the loop of the error contracts while |m - 1| times the
/// complementary sensitivity's peak, which is 1 for a PI that cancels the pole, stays below 1).
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
