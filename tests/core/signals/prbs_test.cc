#include "core/signals/prbs.h"

#include <gtest/gtest.h>

#include <limits>

namespace faultlab::core {
namespace {

class PrbsOrder : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(EveryOrder, PrbsOrder, testing::Range(kPrbsOrderMin, kPrbsOrderMax + 1));

TEST_P(PrbsOrder, RegisterVisitsEveryContentButZeroBeforeItReturns) {
  ShiftRegister bits(GetParam(), 42);
  const std::uint32_t start = bits.content();
  std::uint32_t steps = 0;
  do {
    bits.Step();
    ASSERT_NE(bits.content(), 0U);
    ++steps;
  } while (bits.content() != start && steps <= bits.period());
  EXPECT_EQ(steps, bits.period());
}

TEST_P(PrbsOrder, SequenceHasOneMoreHighThanLow) {
  ShiftRegister bits(GetParam(), 1);
  std::int64_t balance = 0;
  for (std::uint32_t i = 0; i < bits.period(); ++i) {
    balance += bits.Step() ? 1 : -1;
  }
  EXPECT_EQ(balance, 1);
}

TEST(Prbs, AutocorrelationIsThatOfAMaximalLengthSequence) {
  constexpr int kPeriod = 1023;
  const std::vector<double> uc_v =
      MakePrbs({.low_v = -1.0, .high_v = 1.0, .seed = 9}, 2 * kPeriod, 0.01);
  for (int lag = 0; lag < kPeriod; ++lag) {
    double sum = 0.0;
    for (int k = 0; k < kPeriod; ++k) {
      sum += uc_v[static_cast<std::size_t>(k)] * uc_v[static_cast<std::size_t>(k + lag)];
    }
    EXPECT_EQ(sum, lag == 0 ? kPeriod : -1.0) << lag;  // closed form
  }
}

TEST(Prbs, ASlowerClockHoldsEachBitForItsSamples) {
  const std::vector<double> fast = MakePrbs({}, 400, 0.01);
  const std::vector<double> slow = MakePrbs({.clock_s = 0.05}, 2000, 0.01);
  for (std::size_t k = 0; k < slow.size(); ++k) {
    EXPECT_EQ(slow[k], fast[k / 5]) << k;
  }
}

TEST(Prbs, LevelsAreTheTwoOfTheSpecification) {
  int high = 0;
  for (const double value : MakePrbs({}, 2000, 0.01)) {
    EXPECT_TRUE(value == 2.0 || value == 3.0) << value;
    high += value == 3.0;
  }
  EXPECT_NEAR(high, 1000, 60);
}

TEST(Prbs, SeedMovesThePhaseAlone) {
  EXPECT_EQ(MakePrbs({.seed = 3}, 500, 0.01), MakePrbs({.seed = 3}, 500, 0.01));
  EXPECT_NE(MakePrbs({.seed = 3}, 500, 0.01), MakePrbs({.seed = 4}, 500, 0.01));
}

TEST(Prbs, RefusalsNameTheField) {
  EXPECT_EQ(Validate(PrbsSpec{.order = 2}, 0.01).error().field, "order");
  EXPECT_EQ(Validate(PrbsSpec{.order = 21}, 0.01).error().field, "order");
  EXPECT_EQ(Validate(PrbsSpec{.clock_s = 0.005}, 0.01).error().field, "clock_s");
  EXPECT_EQ(Validate(PrbsSpec{.low_v = 3.0, .high_v = 3.0}, 0.01).error().field, "high_v");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Validate(PrbsSpec{.low_v = nan}, 0.01).error().field, "low_v");
  EXPECT_EQ(Validate(PrbsSpec{.clock_s = nan}, 0.01).error().field, "clock_s");
  EXPECT_THROW(MakePrbs(PrbsSpec{.order = 2}, 10, 0.01), ContractError);
}

}  // namespace
}  // namespace faultlab::core
