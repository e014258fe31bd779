#include "core/plant/converters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

const Converters kConverters = paper::Hardware().converters;
const double kRangeV = kConverters.range_v;
const double kConverterStepV = 2.0 * kRangeV / kConverterSteps;
const int kPulses = kConverters.pulses_per_revolution;
constexpr double kGear = paper::kGearRatio;

TEST(Converters, ErrorIsAtMostHalfAStepInsideTheRange) {
  for (double v = -9.999; v < 9.999; v += 0.0037) {
    EXPECT_LE(std::abs(Convert(v, kRangeV) - v), 0.5 * kConverterStepV * (1 + 1e-12)) << v;
  }
}

TEST(Converters, SaturateAtTheRails) {
  EXPECT_EQ(ConverterCode(12.0, kRangeV), 32767);
  EXPECT_EQ(ConverterCode(-12.0, kRangeV), -32768);
  EXPECT_DOUBLE_EQ(Convert(12.0, kRangeV), 10.0 - kConverterStepV);
}

TEST(Converters, CodesSurviveTheRoundTrip) {
  for (const int code : {-32768, -1, 0, 1, 12345, 32767}) {
    const auto value = static_cast<std::int16_t>(code);
    EXPECT_EQ(ConverterCode(ConverterVoltage(value, kRangeV), kRangeV), value);
  }
}

TEST(Encoder, CountsAThousandPulsesForATurn) {
  EXPECT_EQ(EncoderPulses(2.0 * std::numbers::pi * 3.0 + 1e-6, kPulses), 3000);
  EXPECT_EQ(EncoderPulses(-1e-6, kPulses), -1);
}

TEST(PulseCounter, GivesTheMeanOfWhatPassedSinceTheLastReading) {
  PulseCounter counter(kPulses, kGear);
  EXPECT_TRUE(std::isnan(counter.Rpm(3.0, 0.01)));
  const double turn = 2.0 * std::numbers::pi;
  EXPECT_NEAR(counter.Rpm(3.0 + 0.25 * turn, 0.01), 60.0 * 25.0 / kGear, 1.01 * 6.0 / kGear);
  EXPECT_EQ(counter.Rpm(3.0 + 0.25 * turn, 0.01), 0.0);
  EXPECT_LT(counter.Rpm(3.0, 0.01), 0.0);
}

TEST(Encoder, PulsePeriodReadsSpeedBehindTheGearWithinOneTick) {
  for (const double rpm : {-600.0, 60.0, 300.0, 600.0, 1000.0}) {
    // One tick of 25 ns in a pulse of 60 / (1000 * 3.8 * rpm) s.
    const double step_rpm = rpm * rpm * 1000.0 * paper::kGearRatio / 60.0 / kEncoderTimerHz;
    EXPECT_NEAR(SpeedFromPulsePeriodRpm(MotorRadPerS(rpm, kGear), kPulses, kGear), rpm, step_rpm)
        << rpm;
  }
  EXPECT_EQ(SpeedFromPulsePeriodRpm(0.0, kPulses, kGear), 0.0);
  EXPECT_EQ(SpeedFromPulsePeriodRpm(0.01, kPulses, kGear), 0.0);  // under one pulse in 10 ms
}

TEST(Encoder, GatedCountReadsSpeedWithinOnePulse) {
  const double omega = 200.0;
  const auto pulses = EncoderPulses(omega * 1.01, kPulses) - EncoderPulses(omega * 1.0, kPulses);
  EXPECT_NEAR(SpeedFromPulseCountRpm(pulses, 0.01, kPulses, kGear), GearRpm(omega, kGear), 1.58);
}

TEST(Acquire, AddsNoiseOfTheStatedLevelsAndConverts) {
  const NoiseLevels levels = paper::Hardware().noise;
  MeasurementNoise noise(levels, 1);
  const PlantOutputs outputs{.ua_v = 7.2, .um_v = 7.1, .ia_a = 0.03, .omega_rad_s = 220.0};
  constexpr int kReadings = 50'000;
  double sum[4] = {};
  double squares[4] = {};
  const double clean[4] = {7.1, 7.2, 0.03, SpeedFromPulsePeriodRpm(220.0, kPulses, kGear)};
  for (int k = 0; k < kReadings; ++k) {
    Sample sample;
    Acquire(outputs, kConverters, kGear, noise, sample);
    const double read[4] = {sample.um_v, sample.ua_v, sample.ia_a, sample.n_rpm};
    EXPECT_EQ(Convert(sample.um_v, kRangeV), sample.um_v);
    for (int c = 0; c < 4; ++c) {
      sum[c] += (read[c] - clean[c]) / kReadings;
      squares[c] += (read[c] - clean[c]) * (read[c] - clean[c]) / kReadings;
    }
  }
  const double sigma[4] = {levels.um_v, levels.ua_v, levels.ia_a, levels.n_rpm};
  for (int c = 0; c < 4; ++c) {
    EXPECT_NEAR(sum[c], 0.0, 5 * sigma[c] / std::sqrt(kReadings)) << c;
    EXPECT_NEAR(std::sqrt(squares[c]), sigma[c], 0.02 * sigma[c]) << c;
  }
}

}  // namespace
}  // namespace faultlab::core
