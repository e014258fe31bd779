#pragma once

#include <cstdint>
#include <cstdlib>

#include "core/types/sample.h"
#include "hardware/daq/channel_scaling.h"
#include "hardware/device/messages.h"

namespace faultlab::hardware {

/// Signed speed from what a device says of its encoder with each sample.
///   kGatedCount      pulses since the sample before, by the time between the two: steps of a pulse
///   kPulseFrequency  time between pulses: those during the conversions, if they are enough, so
///   that
///                    the speed is that of the moment at which um is read; else those since the
///                    sample before, from newest to newest
/// The first sample of a run has no speed by kGatedCount; by kPulseFrequency 0 is a reading.
class EncoderSpeed {
 public:
  /// @param scaling  outlives this
  explicit EncoderSpeed(const ChannelScaling& scaling) : scaling_(scaling) {}

  void StartRun() { has_before_ = false; }

  /// @param t_s  of the sample's tick, device time
  /// @returns rpm of the shaft behind the gear, or kAbsent
  double Rpm(const DeviceSample& sample, double t_s) {
    const double counted_s = t_s + sample.converted_us * 1e-6;
    const bool moved = sample.edge_age_us != kNoEdge;
    const double edge_s = moved ? counted_s - sample.edge_age_us * 1e-6 : counted_s;
    const auto pulses = static_cast<std::int32_t>(static_cast<std::uint32_t>(sample.count) -
                                                  static_cast<std::uint32_t>(before_.count));
    const bool by_count = scaling_.speed == SpeedMethod::kGatedCount;
    const double gate_s = by_count ? counted_s - counted_before_s_ : edge_s - edge_before_s_;
    double rpm = by_count ? core::kAbsent : 0.0;
    if (!by_count && sample.gate_tenth_us > 0 && std::abs(sample.gate_count) >= kGatePulses) {
      rpm = scaling_.RpmOfFrequency(sample.gate_count / (sample.gate_tenth_us * 1e-7));
    } else if (has_before_ && gate_s > 0.0) {
      rpm = scaling_.RpmOfFrequency(pulses / gate_s);
    }
    before_ = sample;
    counted_before_s_ = counted_s;
    edge_before_s_ = edge_s;
    has_before_ = true;
    return rpm;
  }

 private:
  /// The device sees each pulse some microseconds late, never twice alike.
  static constexpr int kGatePulses = 8;

  const ChannelScaling& scaling_;
  DeviceSample before_;
  double counted_before_s_ = 0.0;
  double edge_before_s_ = 0.0;
  bool has_before_ = false;
};

}  // namespace faultlab::hardware
