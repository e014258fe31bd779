#include "core/isolation/speed_rounding.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

constexpr double kStepS = 4e-6;  // 1000 pulses a revolution, 40 MHz
constexpr double kInputV = 2.0;

PredictionModel Healthy() {
  return MakePredictionModel(paper::Rig(), paper::Noise(), paper::kPeriodS);
}

double HealthySpeed() {
  return TurningState(Healthy(), kInputV)(2);
}

std::vector<Observation> Speeds(const std::vector<double>& speeds) {
  std::vector<Observation> stretch;
  for (const double w : speeds) {
    stretch.push_back({.u_prev = kInputV, .u = kInputV, .y = {0.0, 0.0, w}, .mask = 4});
  }
  return stretch;
}

TEST(SpeedRounding, OfTheHealthySpeedAddsNothing) {
  const std::vector<double> steady(100, HealthySpeed());
  EXPECT_NEAR(AddedRounding(Healthy(), kStepS, Speeds(steady)), 0.0, 1e-9);
}

TEST(SpeedRounding, OfAFasterMotorIsItsStepLessTheHealthyOne) {
  // The speed changes by more than a step from sample to sample.
  std::vector<double> moving;
  double expected = 0.0;
  for (int k = 0; k < 100; ++k) {
    moving.push_back((k % 2 == 0 ? 2.9 : 3.1) * HealthySpeed());
    expected += RoundingVariance(moving.back(), kStepS) / 100.0;
  }
  expected -= RoundingVariance(HealthySpeed(), kStepS);
  EXPECT_NEAR(AddedRounding(Healthy(), kStepS, Speeds(moving)), expected, 1e-6 * expected);
}

TEST(SpeedRounding, ConstantSpeedKeepsItsError) {
  const std::vector<double> steady(100, 3.0 * HealthySpeed());
  const double alone =
      RoundingVariance(3.0 * HealthySpeed(), kStepS) - RoundingVariance(HealthySpeed(), kStepS);
  EXPECT_NEAR(AddedRounding(Healthy(), kStepS, Speeds(steady)), 50.0 * alone, 1e-6 * alone);
}

TEST(SpeedRounding, WithoutASpeedThereIsNone) {
  std::vector<Observation> stretch = Speeds(std::vector<double>(10, 1000.0));
  for (Observation& o : stretch) o.mask = 3;
  EXPECT_EQ(AddedRounding(Healthy(), kStepS, stretch), 0.0);
}

}  // namespace
}  // namespace faultlab::core
