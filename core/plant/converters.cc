#include "core/plant/converters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/types/plant_parameters.h"

namespace faultlab::core {
namespace {

constexpr double kRpmPerRadPerS = 60.0 / (2.0 * std::numbers::pi);
constexpr double kPulsesPerRad = kEncoderPulsesPerRevolution / (2.0 * std::numbers::pi);
constexpr double kPulseTimeoutS = 0.01;

}  // namespace

std::int16_t ConverterCode(double voltage_v) {
  constexpr double kMin = std::numeric_limits<std::int16_t>::min();
  constexpr double kMax = std::numeric_limits<std::int16_t>::max();
  return static_cast<std::int16_t>(std::clamp(std::round(voltage_v / kConverterStepV), kMin, kMax));
}

double ConverterVoltage(std::int16_t code) {
  return code * kConverterStepV;
}

double Convert(double voltage_v) {
  return ConverterVoltage(ConverterCode(voltage_v));
}

std::int64_t EncoderPulses(double angle_rad) {
  return static_cast<std::int64_t>(std::floor(angle_rad * kPulsesPerRad));
}

double SpeedFromPulsePeriodRpm(double omega_rad_s) {
  const double pulses_per_s = std::abs(omega_rad_s) * kPulsesPerRad;
  if (pulses_per_s * kPulseTimeoutS < 1.0) {
    return 0.0;
  }
  const double ticks = std::max(1.0, std::round(kEncoderTimerHz / pulses_per_s));
  return std::copysign(GearRpm(kEncoderTimerHz / ticks / kPulsesPerRad), omega_rad_s);
}

double SpeedFromPulseCountRpm(std::int64_t pulses, double gate_s) {
  return GearRpm(static_cast<double>(pulses) / gate_s / kPulsesPerRad);
}

double GearRpm(double omega_rad_s) {
  return omega_rad_s * kRpmPerRadPerS / kGearRatio;
}

double MotorRadPerS(double gear_rpm) {
  return gear_rpm * kGearRatio / kRpmPerRadPerS;
}

void Acquire(const PlantOutputs& outputs, MeasurementNoise& noise, Sample& sample) {
  sample.um_v = Convert(noise.um_v(outputs.um_v));
  sample.ua_v = Convert(noise.ua_v(outputs.ua_v));
  sample.ia_a = Convert(noise.ia_a(outputs.ia_a) * kCurrentSenseVPerA) / kCurrentSenseVPerA;
  sample.n_rpm = noise.n_rpm(SpeedFromPulsePeriodRpm(outputs.omega_rad_s));
}

}  // namespace faultlab::core
