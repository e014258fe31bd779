#include "core/signals/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace faultlab::core {
namespace {

TEST(Random, SplitMixAndXoshiroGiveTheirPublishedNumbers) {
  // splitmix64(1234567): 6457827717110365317, 3203168211198807973, .. (reference implementation by
  // Vigna). xoshiro256++ from that state: first word rotl(s0 + s3, 23) + s0.
  const std::array<std::uint64_t, 4> state = {
      6457827717110365317U, 3203168211198807973U, 9817491932198370423U, 4593380528125082431U};
  const std::uint64_t sum = state[0] + state[3];
  EXPECT_EQ(Random(1234567).Next(), ((sum << 23U) | (sum >> 41U)) + state[0]);
}

TEST(Random, SameSeedSameNumbersOtherSeedOthers) {
  Random a(5);
  Random b(5);
  Random c(6);
  int equal = 0;
  for (int i = 0; i < 1000; ++i) {
    const double value = a.Normal();
    EXPECT_EQ(value, b.Normal());
    equal += value == c.Normal();
  }
  EXPECT_EQ(equal, 0);
}

TEST(Random, NormalHasTheMomentsAndTailsOfTheNormalDistribution) {
  Random random(1);
  constexpr int kDraws = 2'000'000;
  std::array<double, 5> moment{};
  std::array<int, 5> beyond{};  // |x| > 1, 2, 3, 4, kTail
  const std::array<double, 5> limits = {1.0, 2.0, 3.0, 4.0, 3.442619855899};
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.Normal();
    double power = 1.0;
    for (double& m : moment) {
      m += power / kDraws;
      power *= x;
    }
    for (std::size_t j = 0; j < limits.size(); ++j) {
      beyond[j] += std::abs(x) > limits[j];
    }
  }
  // Standard errors of the moments of kDraws normals are sqrt(1, 2, 15, 96) / 1414.
  EXPECT_NEAR(moment[1], 0.0, 5 * 1.0 / 1414);
  EXPECT_NEAR(moment[2], 1.0, 5 * 1.42 / 1414);
  EXPECT_NEAR(moment[3], 0.0, 5 * 3.9 / 1414);
  EXPECT_NEAR(moment[4], 3.0, 5 * 9.8 / 1414);
  for (std::size_t j = 0; j < limits.size(); ++j) {
    const double expected = kDraws * std::erfc(limits[j] / std::sqrt(2.0));
    EXPECT_NEAR(beyond[j], expected, 5 * std::sqrt(expected)) << limits[j];
  }
}

TEST(Random, BelowIsFairAndStaysBelow) {
  Random random(3);
  std::vector<int> counts(7);
  for (int i = 0; i < 70'000; ++i) {
    ++counts.at(random.Below(7));
  }
  for (const int count : counts) {
    EXPECT_NEAR(count, 10'000, 5 * 100);
  }
}

TEST(Random, StreamsOfOneRunDiffer) {
  Random a(StreamSeed(1, 0));
  Random b(StreamSeed(1, 1));
  double correlation = 0.0;
  constexpr int kDraws = 100'000;
  for (int i = 0; i < kDraws; ++i) {
    correlation += a.Normal() * b.Normal() / kDraws;
  }
  EXPECT_NEAR(correlation, 0.0, 5 / std::sqrt(kDraws));
}

}  // namespace
}  // namespace faultlab::core
