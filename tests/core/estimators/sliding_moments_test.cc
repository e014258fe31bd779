#include "core/estimators/sliding_moments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <limits>
#include <random>

namespace faultlab::core {
namespace {

using Moments = SlidingMoments<3>;

Moments::Packed BatchSums(const std::deque<Moments::Row>& rows) {
  Moments::Packed sums{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      long double sum = 0.0L;
      for (const Moments::Row& row : rows) {
        sum += static_cast<long double>(row[static_cast<std::size_t>(i)]) *
               static_cast<long double>(row[static_cast<std::size_t>(j)]);
      }
      sums[PackedIndex(i, j)] = static_cast<double>(sum);
    }
  }
  return sums;
}

class RandomRows {
 public:
  explicit RandomRows(std::uint64_t seed) : random_(seed) {}
  Moments::Row Next() { return {value_(random_), 2.5 + value_(random_), value_(random_)}; }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> value_;
};

double WorstRelativeError(const Moments::Packed& sums, const Moments::Packed& truth) {
  double scale = 0.0;
  double worst = 0.0;
  for (std::size_t p = 0; p < sums.size(); ++p) {
    scale = std::max(scale, std::abs(truth[p]));
    worst = std::max(worst, std::abs(sums[p] - truth[p]));
  }
  return worst / scale;
}

/// Pushes `rows` into both and compares at every step from `compare_from` on.
double WorstOver(Moments& moments,
                 std::deque<Moments::Row>& window,
                 RandomRows& rows,
                 int count,
                 int compare_from) {
  double worst = 0.0;
  for (int k = 0; k < count; ++k) {
    const Moments::Row row = rows.Next();
    moments.Push(row);
    window.push_back(row);
    if (static_cast<int>(window.size()) > moments.window()) {
      window.pop_front();
    }
    if (k >= compare_from) {
      worst = std::max(worst, WorstRelativeError(moments.sums(), BatchSums(window)));
    }
  }
  return worst;
}

TEST(SlidingMoments, EqualTheBatchSumsAtEverySampleForSeveralWindows) {
  for (int window : {1, 2, 7, 50}) {
    Moments moments(window);
    std::deque<Moments::Row> kept;
    RandomRows rows(static_cast<std::uint64_t>(window));
    EXPECT_LT(WorstOver(moments, kept, rows, 5 * window + 3, 0), 1e-13) << "window " << window;
  }
}

TEST(SlidingMoments, DoNotDriftOverAMillionSamples) {
  Moments moments(100);
  std::deque<Moments::Row> kept;
  RandomRows rows(7);
  EXPECT_LT(WorstOver(moments, kept, rows, 1'000'000, 999'800), 1e-13);
}

TEST(SlidingMoments, ForgetAGlitchAfterTwoWindows) {
  Moments moments(20);
  moments.Push({1e6, -1e6, 3e5});
  std::deque<Moments::Row> kept;
  RandomRows rows(3);
  EXPECT_LT(WorstOver(moments, kept, rows, 200, 2 * 20), 1e-13);
}

TEST(SlidingMoments, HealAfterANonFiniteRowThatSlippedIn) {
  Moments moments(20);
  moments.Push({std::numeric_limits<double>::quiet_NaN(), 1.0, 1.0});
  std::deque<Moments::Row> kept;
  RandomRows rows(4);
  EXPECT_LT(WorstOver(moments, kept, rows, 200, 2 * 20), 1e-13);
}

TEST(SlidingMoments, CountEmptyAndInvalidSlotsUntilTheyLeave) {
  Moments moments(4);
  moments.Push({1.0, 1.0, 1.0});
  moments.PushEmpty(RowKind::kInvalid);
  moments.PushEmpty(RowKind::kEmpty);
  EXPECT_FALSE(moments.full());
  moments.Push({2.0, 0.0, 0.0});
  EXPECT_TRUE(moments.full());
  EXPECT_EQ(moments.rows(), 2);
  EXPECT_EQ(moments.invalid(), 1);
  EXPECT_DOUBLE_EQ(moments.sums()[0], 5.0);
  moments.Push({3.0, 0.0, 0.0});
  moments.Push({4.0, 0.0, 0.0});
  EXPECT_EQ(moments.invalid(), 0);
  EXPECT_EQ(moments.rows(), 3);
  EXPECT_DOUBLE_EQ(moments.sums()[0], 4.0 + 9.0 + 16.0);
}

TEST(SlidingMoments, StartAgainAfterClear) {
  Moments moments(3);
  moments.Push({5.0, 5.0, 5.0});
  moments.PushEmpty(RowKind::kInvalid);
  moments.Clear();
  EXPECT_EQ(moments.rows(), 0);
  EXPECT_EQ(moments.invalid(), 0);
  EXPECT_FALSE(moments.full());
  moments.Push({2.0, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(moments.sums()[0], 4.0);
}

TEST(SlidingMoments, RefuseAWindowWithoutSlots) {
  EXPECT_THROW(Moments(0), ContractError);
}

}  // namespace
}  // namespace faultlab::core
