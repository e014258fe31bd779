#include "core/numerics/golden_section.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

TEST(GoldenSection, ClosesInOnTheMinimumByTheGoldenRatioAStep) {
  int evaluations = 0;
  const auto cost = [&](double x) {
    ++evaluations;
    return std::abs(x - 0.3);
  };
  const GoldenSection section = SearchGoldenSection(-1.0, 2.0, 20, cost);
  EXPECT_EQ(evaluations, 22);
  EXPECT_NEAR(section.b - section.a, 3.0 * std::pow(GoldenSection::kRatio, 20), 1e-12);
  EXPECT_LE(section.a, 0.3);
  EXPECT_GE(section.b, 0.3);
  EXPECT_EQ(section.best_cost(), std::min(section.f1, section.f2));
}

TEST(GoldenSection, FindsAMinimumAtAnEnd) {
  const auto rising = [](double x) { return x; };
  const auto falling = [](double x) { return -x; };
  EXPECT_NEAR(SearchGoldenSection(1.0, 4.0, 40, rising).best(), 1.0, 1e-7);
  EXPECT_NEAR(SearchGoldenSection(1.0, 4.0, 40, falling).best(), 4.0, 1e-7);
}

}  // namespace
}  // namespace faultlab::core
