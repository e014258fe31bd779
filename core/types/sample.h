#pragma once

#include <cstdint>
#include <limits>

namespace faultlab::core {

inline constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

/// Which measured channels a diagnosis may use. Channels that a record lacks are never used.
enum class Channels { kUmOnly, kAll };

/// One line of a recording: the readings of the converters at sample `index`. um_v .. n_rpm were
/// read `delta` seconds after the DAC edge that set uc_v (core/README.md).
/// A channel that the rig does not have, or a lost reading, is NaN.
struct Sample {
  std::int64_t index = 0;  ///< 0 at the start of the run
  double t_s = 0.0;        ///< run time of the sample; index * period on a rig without overruns
  double uc_v = 0.0;       ///< control voltage, amplifier input
  double um_v = kAbsent;   ///< voltage over the motor, amplifier output after R1
  double ua_v = kAbsent;   ///< armature voltage before R1 (amplifier's output terminal)
  double ia_a = kAbsent;   ///< armature current
  double n_rpm = kAbsent;  ///< speed of the shaft behind the gear
  /// Seconds from the DAC edge to the middle of this sample's conversions, as measured; NaN where
  /// nobody measures it (simulators, recordings from elsewhere).
  double delta_s = kAbsent;
};

}  // namespace faultlab::core
