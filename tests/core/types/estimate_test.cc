#include "core/types/estimate.h"

#include <gtest/gtest.h>

namespace faultlab::core {
namespace {

Estimate<3> Made(EstimateStatus status, double b1_sigma) {
  return {.theta = {2.4, 0.0, 0.0}, .sigma = {0.1, b1_sigma, 0.02}, .status = status};
}

TEST(Shown, LeavesTheGainAloneWhereTheTimeConstantIsNotResolved) {
  const double infinite = std::numeric_limits<double>::infinity();
  const Estimate<3> shown = Shown(Made(EstimateStatus::kWeak, infinite));
  EXPECT_EQ(shown.theta[0], 2.4);
  EXPECT_EQ(shown.sigma[0], 0.1);
  for (const std::size_t i : {1, 2}) {
    EXPECT_TRUE(std::isnan(shown.theta[i])) << "no 0 that somebody could take for a value";
    EXPECT_TRUE(std::isnan(shown.sigma[i]));
  }
}

TEST(Shown, IsTheWholeOfAGoodOneAndNothingOfAnInvalidOne) {
  EXPECT_EQ(Shown(Made(EstimateStatus::kExcited, 0.3)).theta[1], 0.0);
  EXPECT_TRUE(std::isnan(Shown(Made(EstimateStatus::kInvalid, 0.3)).theta[0]));
}

}  // namespace
}  // namespace faultlab::core
