#pragma once

#include <limits>

namespace faultlab::core {

/// What a rig of a class stands. A limit that nobody has stated is none.
struct BenchLimits {
  static constexpr double kNone = std::numeric_limits<double>::infinity();

  double uc_v_min = 0.0;
  double uc_v_max = 0.0;
  double slew_v_per_s = kNone;          ///< steepest change of uc, as step over period
  double voltage_v_max = kNone;         ///< |um|, |ua|
  double current_continuous_a = kNone;  ///< thermal limit, see hardware/rig_limits.h
  double thermal_tau_s = 10.0;          ///< of the winding
  double current_peak_a = kNone;        ///< below the rail of the current channel
  double stall_current_a = kNone;
  double stall_speed_rpm = 10.0;  ///< of the shaft whose speed is n
  double stall_s = 0.5;
  double relay_rest_s = 0.05;  ///< shortest time between two switchings of a board
  /// Closings that a relay's data sheet rates it for. The default is what common signal relays
  /// stand at their full load; small loads such as these wear them less.
  double relay_life = 1e5;
};

}  // namespace faultlab::core
