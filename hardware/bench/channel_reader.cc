#include "hardware/bench/channel_reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "hardware/bench/value_bounds.h"

namespace faultlab::hardware {
namespace {

using core::Bench;

/// Converters of boards that are sold read and write -10 to 10 V.
constexpr double kConverterV = 10.0;
/// Of dividers and shunts with parts of 1 %, when nothing is said; an encoder has none.
constexpr double kAnalogGainSd = 0.005;
constexpr double kGainSdMax = 0.2;

void ReadScale(TomlTable& table, core::BenchChannel& channel) {
  table.Number("v_per_unit", channel.v_per_unit, -1e6, 1e6);
  if (channel.v_per_unit == 0.0) table.Refuse("v_per_unit", "must not be 0");
  table.Number("offset_v", channel.offset_v, -kConverterV, kConverterV);
}

void ReadEnds(TomlTable& table, double largest, std::vector<double>& ends) {
  table.Numbers("range", ends, -largest, largest);
  if (ends.size() != 2 || !(ends[0] < ends[1])) {
    table.Refuse("range", "must be two numbers, the smaller first");
  }
}

void ReadAnalog(TomlTable& channels,
                const char* name,
                double zero_per_noise,
                core::BenchChannel& channel) {
  TomlTable& table = channels.Sub(name);
  if (!channels.Has(name)) return;
  channel.exists = true;
  std::vector<double> ends = {-kConverterV, kConverterV};
  ReadEnds(table, 1e9, ends);
  channel.min = ends[0];
  channel.max = ends[1];
  // What a converter of 12 bit adds, when nothing is said; and never none at all.
  constexpr double kNoiseShare = 7e-5;
  constexpr double kNoiseShareMin = 1e-6;
  channel.noise = kNoiseShare * (ends[1] - ends[0]);
  table.Number("noise", channel.noise, 0.0, 1e6);
  channel.noise = std::max(channel.noise, kNoiseShareMin * (ends[1] - ends[0]));
  channel.zero_sd = zero_per_noise * channel.noise;
  table.Number("zero_sd", channel.zero_sd, 0.0, ends[1] - ends[0]);
  channel.gain_sd = kAnalogGainSd;
  table.Number("gain_sd", channel.gain_sd, 0.0, kGainSdMax);
  channel.v_per_unit = kConverterV / std::max(std::abs(ends[0]), std::abs(ends[1]));
  ReadScale(table, channel);
}

/// In rpm of the shaft behind the gear; the encoder sits on the motor shaft.
void ReadSpeed(TomlTable& channels, Bench& bench) {
  TomlTable& table = channels.Sub("n");
  const bool is_encoder = table.Has("pulses_per_revolution");
  table.Integer("pulses_per_revolution", bench.pulses_per_revolution, 1, 1'000'000);
  double timer_hz = 40e6;
  table.Number("timer_hz", timer_hz, 0.0, 1e12);
  if (timer_hz > 0.0) {
    bench.n.step_s = bench.pulses_per_revolution / (2.0 * std::numbers::pi * timer_hz);
  }
  if (!channels.Has("n")) return;
  constexpr double kNoiseMin = 1e-6;
  constexpr double kSecondsPerMinute = 60.0;
  bench.n = {
      .exists = true, .noise = 1.0, .min = -kRpmMax, .max = kRpmMax, .step_s = bench.n.step_s};
  table.Number("noise", bench.n.noise, 0.0, 1e6);
  bench.n.noise = std::max(bench.n.noise, kNoiseMin);
  bench.n.tachometer = timer_hz <= 0.0 && !is_encoder;
  table.Number("zero_sd", bench.n.zero_sd, 0.0, kRpmMax);
  table.Number("gain_sd", bench.n.gain_sd, 0.0, kGainSdMax);
  std::vector<double> ends = {bench.n.min, bench.n.max};
  ReadEnds(table, kRpmMax, ends);
  bench.n.min = ends[0];
  bench.n.max = ends[1];
  table.Flag("counted", bench.n.counted);
  if (!bench.n.counted) return;
  // A count is off by the parts of a pulse at either end, whatever the speed.
  bench.n.step_s = 0.0;
  const double step_rpm =
      kSecondsPerMinute / (bench.pulses_per_revolution * bench.nominal.gear_ratio * bench.period_s);
  bench.n.noise = std::max(bench.n.noise, step_rpm / std::sqrt(6.0));
}

}  // namespace

void ReadChannels(TomlTable& root, Bench& bench) {
  TomlTable& channels = root.Sub("channel");
  ReadScale(channels.Sub("uc"), bench.uc);
  // When nothing is said. A current is measured by a small voltage, whose zero drifts.
  constexpr double kVoltageZeroPerNoise = 2.0;
  constexpr double kCurrentZeroPerNoise = 5.0;
  ReadAnalog(channels, "um", kVoltageZeroPerNoise, bench.um);
  ReadAnalog(channels, "ua", kVoltageZeroPerNoise, bench.ua);
  ReadAnalog(channels, "ia", kCurrentZeroPerNoise, bench.ia);
  ReadSpeed(channels, bench);
  const core::EstimatedChannel estimated = bench.structure->estimated;
  const bool measured = estimated == core::EstimatedChannel::kUm   ? bench.um.exists
                        : estimated == core::EstimatedChannel::kIa ? bench.ia.exists
                                                                   : bench.n.exists;
  if (!measured) {
    const bool speed_alone = bench.n.exists && !bench.um.exists && !bench.ia.exists;
    root.Refuse(
        "channel",
        "must have " + std::string(core::InfoOf(estimated).name) + ": the structure " +
            std::string(bench.structure->name) + " is estimated by it" +
            (speed_alone ? "; where the speed alone is measured, it is motor-by-speed" : ""));
  }
}

}  // namespace faultlab::hardware
