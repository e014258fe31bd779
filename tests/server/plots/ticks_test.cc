#include "server/plots/ticks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace faultlab::server {
namespace {

using ::testing::ElementsAre;

TEST(Ticks, AreRoundNumbersWithEqualDecimalsAndATrueMinusSign) {
  EXPECT_THAT(MakeTicks(0.0, 20.0, 11).labels,
              ElementsAre("0", "2", "4", "6", "8", "10", "12", "14", "16", "18", "20"));
  EXPECT_THAT(MakeTicks(-0.03, 0.05, 5).labels, ElementsAre("\u22120.02", "0.00", "0.02", "0.04"));
}

TEST(Ticks, MoveTinyAndHugeNumbersIntoAnExponent) {
  const Ticks tiny = MakeTicks(0.0, 1.43e-6, 4);
  EXPECT_EQ(tiny.exponent, -6);
  EXPECT_THAT(tiny.labels, ElementsAre("0.0", "0.5", "1.0"));
  EXPECT_EQ(MakeTicks(0.0, 4e6, 5).exponent, 6);
  EXPECT_EQ(MakeTicks(0.0, 0.04, 5).exponent, 0);
}

TEST(Ticks, LieInsideTheRangeAndNeverExceedTheCount) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> exponent(-9.0, 9.0);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 5000; ++i) {
    const double from = normal(random) * std::pow(10.0, exponent(random));
    const double to = from + std::abs(normal(random)) * std::pow(10.0, exponent(random));
    if (!(to - from > 1e-6 * std::abs(from))) {
      continue;  // too narrow to be distinguished from a point in double precision
    }
    const Ticks ticks = MakeTicks(from, to, 7);
    ASSERT_GE(ticks.at.size(), 1u) << from << ' ' << to;
    ASSERT_LE(ticks.at.size(), 7u);
    ASSERT_EQ(ticks.at.size(), ticks.labels.size());
    const double slack = 1e-6 * (to - from);
    EXPECT_GE(ticks.at.front(), from - slack);
    EXPECT_LE(ticks.at.back(), to + slack);
    for (std::size_t k = 1; k < ticks.labels.size(); ++k) {
      EXPECT_NE(ticks.labels[k], ticks.labels[k - 1]) << from << ' ' << to;
    }
  }
}

TEST(Ticks, GiveASingleValueRoomAroundIt) {
  const auto [low, high] = WithMargin(5.0, 5.0);
  EXPECT_LT(low, 5.0);
  EXPECT_GT(high, 5.0);
  const auto zero = WithMargin(0.0, 0.0);
  EXPECT_LT(zero.first, zero.second);
}

}  // namespace
}  // namespace faultlab::server
