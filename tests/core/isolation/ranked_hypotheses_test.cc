#include "core/isolation/ranked_hypotheses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/core/isolation/fault_stretch.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

const std::vector<Component> kAll(paper::Parts().begin(), paper::Parts().end());

TEST(RankedHypotheses, PutTheRightComponentFirst) {
  FaultStretch fault({AbruptFault(paper::kJ, 1.43e-5, 1.0)}, 121);
  const RankedHypotheses ranked =
      RankHypotheses(fault.context, kAll, ValuePrior::kNone, FitPolicy::kFitAll);
  ASSERT_EQ(ranked.fits.size(), kAll.size());
  EXPECT_EQ(ranked.best().component, paper::kJ);
  EXPECT_NEAR(ranked.best().value, 1.43e-5, 0.05e-5);
  EXPECT_TRUE(std::is_sorted(ranked.fits.begin(), ranked.fits.end(), LikelierFirst));
  EXPECT_FALSE(ranked.off_list);
}

TEST(RankedHypotheses, StoppingLosersDoesNotChangeTheWinner) {
  for (Component component : {paper::kR1, paper::kRa, paper::kB}) {
    const double value = 4.0 * paper::Plant().Get(component);
    FaultStretch fault({AbruptFault(component, value, 1.0)}, 122);
    const auto best = [&](FitPolicy policy) {
      return RankHypotheses(fault.context, kAll, ValuePrior::kNone, policy).best();
    };
    EXPECT_EQ(best(FitPolicy::kFitAll).component, component);
    EXPECT_EQ(best(FitPolicy::kStopLosers).component, component);
    EXPECT_EQ(best(FitPolicy::kStopLosers).value, best(FitPolicy::kFitAll).value);
  }
}

TEST(RankedHypotheses, TakeTheListedValueOrSayThatNoneFits) {
  FaultStretch listed({AbruptFault(paper::kR1, 56.0, 1.0)}, 123);
  const auto rank = [](const FaultStretch& fault) {
    return RankHypotheses(fault.context, kAll, ValuePrior::kTable2, FitPolicy::kFitAll);
  };
  EXPECT_EQ(rank(listed).best().component, paper::kR1);
  EXPECT_EQ(rank(listed).best().value, 56.0);
  EXPECT_FALSE(rank(listed).off_list);
  FaultStretch between({AbruptFault(paper::kR1, 75.0, 1.0)}, 124);
  EXPECT_TRUE(rank(between).off_list);
  EXPECT_NEAR(rank(between).best().value, 75.0, 1.0);
}

}  // namespace
}  // namespace faultlab::core
