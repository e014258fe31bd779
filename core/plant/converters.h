#pragma once

#include <cstdint>
#include <optional>

#include "core/bench/profile.h"
#include "core/plant/plant.h"
#include "core/signals/random.h"
#include "core/types/sample.h"

namespace faultlab::core {

inline constexpr double kConverterSteps = 65536.0;  ///< 16 bit
inline constexpr double kEncoderTimerHz = 40e6;     ///< clock that times the pulses

/// 16-bit code of a voltage, saturated at the rails.
/// @param range_v  the converter reads -range .. range
std::int16_t ConverterCode(double voltage_v, double range_v);
/// The voltage of a code.
double ConverterVoltage(std::int16_t code, double range_v);
/// Both steps: the voltage that a converter reads.
double Convert(double voltage_v, double range_v);

/// Whole pulses since angle 0; the encoder sits on the motor shaft.
std::int64_t EncoderPulses(double angle_rad, int per_revolution);
/// Speed behind the gear from the time between two pulses, in whole ticks of the timer: steps of
/// 0.3 rpm at 600 rpm, almost no delay. Fewer than one pulse per 10 ms reads as 0.
double SpeedFromPulsePeriodRpm(double omega_rad_s, int per_revolution, double gear_ratio);
/// The same of these converters, as their encoder or tachometer reads it, without noise.
double SpeedReadingRpm(double omega_rad_s, const Converters& converters, double gear_ratio);
/// Speed behind the gear from the pulses counted in a gate: steps of 1.58 rpm at 10 ms, delayed by
/// half a gate.
double SpeedFromPulseCountRpm(std::int64_t pulses,
                              double gate_s,
                              int per_revolution,
                              double gear_ratio);

/// The speed of an encoder whose pulses are counted from one reading to the next.
class PulseCounter {
 public:
  PulseCounter(int per_revolution, double gear_ratio)
      : per_revolution_(per_revolution), gear_ratio_(gear_ratio) {}

  /// The mean speed behind the gear since the last reading; absent at the first.
  double Rpm(double angle_rad, double gate_s);

 private:
  int per_revolution_;
  double gear_ratio_;
  std::optional<std::int64_t> before_;
};

/// rad/s at the motor shaft <-> rpm behind the gear.
double GearRpm(double omega_rad_s, double gear_ratio);
double MotorRadPerS(double gear_rpm, double gear_ratio);

/// White Gaussian noise on each channel, seeded.
class MeasurementNoise {
 public:
  MeasurementNoise(const NoiseLevels& levels, std::uint64_t seed)
      : levels_(levels), random_(seed) {}

  /// The noisy reading, before the converters.
  double um_v(double clean_v) { return clean_v + levels_.um_v * random_.Normal(); }
  double ua_v(double clean_v) { return clean_v + levels_.ua_v * random_.Normal(); }
  double ia_a(double clean_a) { return clean_a + levels_.ia_a * random_.Normal(); }
  double n_rpm(double clean_rpm) { return clean_rpm + levels_.n_rpm * random_.Normal(); }

 private:
  NoiseLevels levels_;
  Random random_;
};

/// The acquisition of the plant's outputs: noise, then converters and encoder. Fills those of um,
/// ua, ia, n of `sample` that the bench has; n where its pulses are timed (Converters::counts).
void Acquire(const PlantOutputs& outputs,
             const Converters& converters,
             double gear_ratio,
             MeasurementNoise& noise,
             Sample& sample);

}  // namespace faultlab::core
