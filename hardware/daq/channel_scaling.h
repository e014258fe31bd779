#pragma once

#include "core/bench/bench.h"
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

/// What stands between the terminals and the quantities of a Sample.
struct ChannelScaling {
  ChannelScale uc;
  ChannelScale um;
  ChannelScale ua;
  ChannelScale ia;
  int pulses_per_revolution = 1000;
  double gear_ratio = 1.0;
  SpeedMethod speed = SpeedMethod::kPulseFrequency;

  double RpmOfFrequency(double pulses_hz) const {
    return pulses_hz * 60.0 / (pulses_per_revolution * gear_ratio);
  }
};

inline ChannelScale ScaleOf(const core::BenchChannel& channel) {
  return {channel.v_per_unit, channel.offset_v};
}

/// As the bench is described.
inline ChannelScaling ScalingOf(const core::Bench& bench) {
  return {.uc = ScaleOf(bench.uc),
          .um = ScaleOf(bench.um),
          .ua = ScaleOf(bench.ua),
          .ia = ScaleOf(bench.ia),
          .pulses_per_revolution = bench.pulses_per_revolution,
          .gear_ratio = bench.nominal.gear_ratio};
}

}  // namespace faultlab::hardware
