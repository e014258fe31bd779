#include "core/detection/noise_scale.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/signals/random.h"

namespace faultlab::core {
namespace {

NoiseScale After(int samples, double sd, int readings = 450) {
  NoiseScale scale(readings);
  Random random(7);
  for (int k = 0; k < samples; ++k) scale.Push(0, sd * random.Normal());
  return scale;
}

TEST(NoiseScale, BelievesTheCalibrationBeforeItHasSeenAnything) {
  const NoiseScale scale(450);
  for (std::size_t c = 0; c < kOutputCount; ++c) EXPECT_DOUBLE_EQ(scale.Weight(c), 1.0);
}

TEST(NoiseScale, SettlesAtTheNoiseThatTheHealthyRecordShows) {
  // The calibration measured 13 mV, the true value is 15 mV: z has a standard deviation of 1.15. 20
  // 000 readings leave a standard error of 0.5 %; the prior's 450 readings change the result by 1
  // %.
  EXPECT_NEAR(After(40'000, 1.15).Weight(0), 1.0 / 1.15, 0.02);
  EXPECT_NEAR(After(40'000, 0.92).Weight(0), 1.0 / 0.92, 0.02);
}

TEST(NoiseScale, LearnsEachChannelByItself) {
  EXPECT_DOUBLE_EQ(After(10'000, 1.15).Weight(1), 1.0);
}

TEST(NoiseScale, NeverLearnsMoreThanSamplingErrorExplains) {
  // Five standard errors of a variance from 450 readings: 1.33.
  EXPECT_NEAR(
      After(100'000, 1.6).Weight(0), 1.0 / std::sqrt(1.0 + 5.0 * std::sqrt(2.0 / 450.0)), 1e-12);
}

TEST(NoiseScale, DoesNotCountWhatIsNoNoise) {
  NoiseScale scale(450);
  for (int k = 0; k < 10'000; ++k) scale.Push(0, 6.0);
  EXPECT_DOUBLE_EQ(scale.Weight(0), 1.0);
}

TEST(NoiseScale, NeedsLessRoomTheMoreItHasSeen) {
  const double fresh = NoiseScale(450).threshold_inflation();
  EXPECT_GT(fresh, 1.05);
  EXPECT_LT(After(2'000, 1.0).threshold_inflation(), fresh);
  EXPECT_LT(After(40'000, 1.0).threshold_inflation(), 1.002);
}

}  // namespace
}  // namespace faultlab::core
