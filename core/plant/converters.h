#pragma once

#include <cstdint>

#include "core/plant/plant.h"
#include "core/plant/profile.h"
#include "core/signals/random.h"
#include "core/types/sample.h"

namespace faultlab::core {

inline constexpr double kConverterRangeV = 10.0;  ///< NI 9205 in, NI 9263 out: +-10 V, 16 bit
inline constexpr double kConverterStepV = 2.0 * kConverterRangeV / 65536.0;
inline constexpr double kCurrentSenseVPerA = 5.0;  ///< scales ia to the converter: +-2 A
inline constexpr int kEncoderPulsesPerRevolution = 1000;
inline constexpr double kEncoderTimerHz = 40e6;  ///< clock that times the pulses

/// 16-bit code of a voltage, saturated at the rails.
std::int16_t ConverterCode(double voltage_v);
/// Volt of a code.
double ConverterVoltage(std::int16_t code);
/// Both: what a converter makes of a voltage.
double Convert(double voltage_v);

/// Whole pulses since angle 0; the encoder sits on the motor shaft.
std::int64_t EncoderPulses(double angle_rad);
/// Speed behind the gear from the time between two pulses, in whole ticks of the timer:
/// 0.3 rpm steps at 600 rpm, almost no delay. Below one pulse per 10 ms reads 0.
double SpeedFromPulsePeriodRpm(double omega_rad_s);
/// Speed behind the gear from pulses counted in a gate: 1.58 rpm steps at 10 ms, half a gate late.
double SpeedFromPulseCountRpm(std::int64_t pulses, double gate_s);

/// rad/s at the motor shaft <-> rpm behind the gear.
double GearRpm(double omega_rad_s);
double MotorRadPerS(double gear_rpm);

/// White Gaussian noise on each channel, seeded.
class MeasurementNoise {
 public:
  MeasurementNoise(const NoiseLevels& levels, std::uint64_t seed)
      : levels_(levels), random_(seed) {}

  /// The noisy reading before the converters.
  double um_v(double clean_v) { return clean_v + levels_.um_v * random_.Normal(); }
  double ua_v(double clean_v) { return clean_v + levels_.ua_v * random_.Normal(); }
  double ia_a(double clean_a) { return clean_a + levels_.ia_a * random_.Normal(); }
  double n_rpm(double clean_rpm) { return clean_rpm + levels_.n_rpm * random_.Normal(); }

 private:
  NoiseLevels levels_;
  Random random_;
};

/// What the acquisition makes of the plant's outputs: noise, then converters and encoder.
/// Fills um, ua, ia, n of `sample`.
void Acquire(const PlantOutputs& outputs, MeasurementNoise& noise, Sample& sample);

}  // namespace faultlab::core
