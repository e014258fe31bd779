#include "core/control/speed_reference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/control/control_quality.h"

namespace faultlab::core {
namespace {

constexpr double kTickS = 0.01;
using Shape = SpeedReference::Shape;

TEST(SpeedReference, GoesBetweenTwoSpeedsInItsShape) {
  SpeedReference reference{
      .shape = Shape::kSteps, .low_rad_s = 100.0, .high_rad_s = 120.0, .hold_s = 0.1};
  const ReferencePlayer steps(reference, kTickS);
  EXPECT_EQ(steps.hold_ticks(), 10U);
  EXPECT_EQ(steps.At(9), 100.0);
  EXPECT_EQ(steps.At(10), 120.0);
  EXPECT_EQ(steps.At(20), 100.0);
  reference.shape = Shape::kRamp;
  const ReferencePlayer ramp(reference, kTickS);
  EXPECT_NEAR(ramp.At(0), 100.0, 1e-12);
  EXPECT_NEAR(ramp.At(5), 110.0, 1e-12);
  EXPECT_NEAR(ramp.At(10), 120.0, 1e-12);
  EXPECT_NEAR(ramp.At(15), 110.0, 1e-12);
  EXPECT_NEAR(ramp.At(20), 100.0, 1e-12);
  reference.shape = Shape::kPrbs;
  const ReferencePlayer prbs(reference, kTickS);
  int high = 0;
  for (std::size_t bit = 0; bit < 1023; ++bit) {
    const double now = prbs.At(10 * bit);
    ASSERT_TRUE(now == 100.0 || now == 120.0);
    ASSERT_EQ(prbs.At(10 * bit + 9), now);
    high += now == 120.0 ? 1 : 0;
  }
  EXPECT_EQ(high, 512) << "a maximal sequence has one more of these";
  EXPECT_EQ(prbs.At(10 * 1023), prbs.At(0));
}

TEST(SpeedReference, RefusesWhatNobodyCanKeep) {
  EXPECT_TRUE(Validate(SpeedReference{}, kTickS).ok());
  EXPECT_EQ(Validate({.low_rad_s = 0.0}, kTickS).error().field, "low_rad_s");
  EXPECT_EQ(Validate({.high_rad_s = std::nan("")}, kTickS).error().field, "high_rad_s");
  EXPECT_EQ(Validate({.high_rad_s = INFINITY}, kTickS).error().field, "high_rad_s");
  for (const double hold_s : {0.0, -1.0, 0.079, 3601.0, std::nan("")}) {
    EXPECT_EQ(Validate({.hold_s = hold_s}, kTickS).error().field, "hold_s") << hold_s;
  }
}

TEST(ControlQuality, IsOfWhatIsKnown) {
  const SpeedReference reference{.low_rad_s = 100.0, .high_rad_s = 120.0, .hold_s = 0.1};
  const ReferencePlayer player(reference, kTickS);
  std::vector<double> wanted;
  std::vector<double> speed;
  for (std::size_t k = 0; k < 60; ++k) {
    wanted.push_back(player.At(k));
    // Two samples late, 5 rad/s beyond the first step up, one reading missing.
    speed.push_back(k < 2 ? 100.0 : player.At(k - 2) + (k == 12 ? 5.0 : 0.0));
  }
  speed[30] = std::nan("");
  const ControlQuality quality = QualityOf(reference,
                                           {.reference_rad_s = wanted,
                                            .speed_rad_s = speed,
                                            .control_from = 0,
                                            .from = 0,
                                            .period_s = kTickS});
  // Five steps of two late samples each, one of them not known; and the overshoot.
  EXPECT_NEAR(quality.iae_rad, (9 * 20.0 + 5.0) * kTickS, 1e-9);
  EXPECT_NEAR(quality.late_iae_rad, 7 * 20.0 * kTickS, 1e-9);
  EXPECT_NEAR(quality.overshoot_percent, 25.0, 1e-9);
  ASSERT_TRUE(quality.settling_s);
  EXPECT_NEAR(*quality.settling_s, 2 * kTickS, 1e-9);
  EXPECT_NEAR(quality.steady_error_rad_s, 0.0, 1e-9);
}

}  // namespace
}  // namespace faultlab::core
