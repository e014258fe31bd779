#pragma once

#include <optional>
#include <string>

#include "core/types/result.h"
#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// What a bench stands. The defaults are the paper's motor and amplifier (Table 1: 12 V, 0.629 A).
struct RigLimits {
  double uc_v_min = 0.0;
  double uc_v_max = 5.0;
  double slew_v_per_s = 1000.0;         ///< steepest change of uc, as step over period
  double voltage_v_max = 12.6;          ///< |um|, |ua|: 12 V and the amplifier's accuracy
  double current_continuous_a = 0.629;  ///< thermal limit, see Interlocks
  double thermal_tau_s = 12.0;          ///< of the winding
  double current_peak_a = 1.9;          ///< below the rail of a +-2 A current channel
  double stall_current_a = 0.4;
  double stall_speed_rpm = 10.0;  ///< behind the gear
  double stall_s = 0.5;
  double relay_rest_s = 0.05;  ///< shortest time between two switchings of a board
};

/// Refuses a plan outside the envelope; `field` names the part, the message the sample.
core::Status CheckExcitation(const RunPlan& plan, const RigLimits& limits);

/// The interlocks that look at each sample. The first that acts latches.
///   over_voltage   |um| or |ua| above voltage_v_max
///   over_current   |ia| above current_peak_a, one sample
///   over_heat      theta > continuous^2, with d theta/dt = (ia^2 - theta)/tau: the winding's
///                  heat relative to what it may bear for ever
///   stall          |ia| above stall_current_a while |n| below stall_speed_rpm for stall_s
/// A channel that the rig lacks is NaN and trips nothing.
class Interlocks {
 public:
  explicit Interlocks(RigLimits limits) : limits_(limits) {}

  /// @param dt_s  time since the sample before
  /// @returns the trip, if this sample causes one.
  std::optional<Trip> Check(const core::Sample& sample, double dt_s);
  /// A new run: the stall timer starts anew; the winding keeps its heat.
  void StartRun() { stalled_s_ = 0.0; }
  /// The motor has been off for this long.
  void Rest(double seconds);
  /// a^2.
  double heat() const { return heat_a2_; }

 private:
  RigLimits limits_;
  double heat_a2_ = 0.0;
  double stalled_s_ = 0.0;
};

}  // namespace faultlab::hardware
