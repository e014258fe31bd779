#pragma once

#include <cstdint>

#include "hardware/daq/daq.h"

namespace faultlab::hardware {

/// value = (terminal volts - offset_v) / v_per_unit.
struct ChannelScale {
  double v_per_unit = 1.0;
  double offset_v = 0.0;

  double ToUnit(double terminal_v) const { return (terminal_v - offset_v) / v_per_unit; }
  double ToTerminal(double value) const { return value * v_per_unit + offset_v; }
};

/// How speed comes from the encoder.
enum class SpeedMethod {
  kPulseFrequency,  ///< the counter measures the time between pulses
  kGatedCount,      ///< pulses counted from one read to the next, by the real time between
};

/// What stands between the terminals and the quantities of a Sample. The +-10 V converters see um
/// and ua behind a 2:1 divider, and ia as 5 V/A.
struct ChannelScaling {
  ChannelScale uc;
  ChannelScale um{.v_per_unit = 0.5};
  ChannelScale ua{.v_per_unit = 0.5};
  ChannelScale ia{.v_per_unit = 5.0};
  int pulses_per_revolution = 1000;
  double gear_ratio = 3.8;
  SpeedMethod speed = SpeedMethod::kPulseFrequency;

  double RpmOfFrequency(double pulses_hz) const {
    return pulses_hz * 60.0 / (pulses_per_revolution * gear_ratio);
  }
};

}  // namespace faultlab::hardware
