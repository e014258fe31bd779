#include "core/plant/converters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/bench/bench.h"

namespace faultlab::core {
namespace {

constexpr double kRpmPerRadPerS = 60.0 / (2.0 * std::numbers::pi);

double PulsesPerRad(int per_revolution) {
  return per_revolution / (2.0 * std::numbers::pi);
}

}  // namespace

std::int16_t ConverterCode(double voltage_v, double range_v) {
  constexpr double kMin = std::numeric_limits<std::int16_t>::min();
  constexpr double kMax = std::numeric_limits<std::int16_t>::max();
  const double step_v = 2.0 * range_v / kConverterSteps;
  return static_cast<std::int16_t>(std::clamp(std::round(voltage_v / step_v), kMin, kMax));
}

double ConverterVoltage(std::int16_t code, double range_v) {
  return code * (2.0 * range_v / kConverterSteps);
}

double Convert(double voltage_v, double range_v) {
  return ConverterVoltage(ConverterCode(voltage_v, range_v), range_v);
}

std::int64_t EncoderPulses(double angle_rad, int per_revolution) {
  return static_cast<std::int64_t>(std::floor(angle_rad * PulsesPerRad(per_revolution)));
}

double SpeedFromPulsePeriodRpm(double omega_rad_s, int per_revolution, double gear_ratio) {
  const double pulses_per_rad = PulsesPerRad(per_revolution);
  const double pulses_per_s = std::abs(omega_rad_s) * pulses_per_rad;
  if (pulses_per_s * kPulseTimeoutS < 1.0) {
    return 0.0;
  }
  const double ticks = std::max(1.0, std::round(kEncoderTimerHz / pulses_per_s));
  return std::copysign(GearRpm(kEncoderTimerHz / ticks / pulses_per_rad, gear_ratio), omega_rad_s);
}

double SpeedReadingRpm(double omega_rad_s, const Converters& converters, double gear_ratio) {
  if (converters.tachometer) return GearRpm(omega_rad_s, gear_ratio);
  return SpeedFromPulsePeriodRpm(omega_rad_s, converters.pulses_per_revolution, gear_ratio);
}

double SpeedFromPulseCountRpm(std::int64_t pulses,
                              double gate_s,
                              int per_revolution,
                              double gear_ratio) {
  return GearRpm(static_cast<double>(pulses) / gate_s / PulsesPerRad(per_revolution), gear_ratio);
}

double GearRpm(double omega_rad_s, double gear_ratio) {
  return omega_rad_s * kRpmPerRadPerS / gear_ratio;
}

double PulseCounter::Rpm(double angle_rad, double gate_s) {
  const std::int64_t now = EncoderPulses(angle_rad, per_revolution_);
  const std::optional<std::int64_t> before = std::exchange(before_, now);
  if (!before) return kAbsent;
  return SpeedFromPulseCountRpm(now - *before, gate_s, per_revolution_, gear_ratio_);
}

double MotorRadPerS(double gear_rpm, double gear_ratio) {
  return gear_rpm * gear_ratio / kRpmPerRadPerS;
}

void Acquire(const PlantOutputs& outputs,
             const Converters& converters,
             double gear_ratio,
             MeasurementNoise& noise,
             Sample& sample) {
  const double range_v = converters.range_v;
  if (converters.has_um) sample.um_v = Convert(noise.um_v(outputs.um_v), range_v);
  if (converters.has_ua) sample.ua_v = Convert(noise.ua_v(outputs.ua_v), range_v);
  if (converters.has_ia) {
    sample.ia_a =
        Convert(noise.ia_a(outputs.ia_a) * converters.ia_v_per_a, range_v) / converters.ia_v_per_a;
  }
  if (converters.has_n && !converters.counts) {
    sample.n_rpm = noise.n_rpm(SpeedReadingRpm(outputs.omega_rad_s, converters, gear_ratio));
  }
}

}  // namespace faultlab::core
