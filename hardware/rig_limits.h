#pragma once

#include <optional>

#include "core/bench/limits.h"
#include "core/types/result.h"
#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// See core/bench/limits.h.
using RigLimits = core::BenchLimits;

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
