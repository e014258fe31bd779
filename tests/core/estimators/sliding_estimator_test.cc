// What the estimators over a sliding window have in common.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/estimators/instrumental_swa.h"
#include "core/estimators/sia.h"
#include "core/estimators/swa.h"
#include "tests/core/estimators/records.h"
#include "tests/support/heap_guard.h"

namespace faultlab::core {
namespace {

using testing::MakeBinary;
using testing::MakeFirstOrder;
using testing::Record;

/// Each has a window of 50 samples.
struct ArxShape {
  static Swa<1> Make() { return Swa<1>({.window_samples = 50}); }
  static constexpr int kSamplesOfAReading = 51;  ///< whose windows contain it
  static constexpr double kSame = 1e-8;          ///< of two that saw the same window
};
struct IntegralShape {
  static Sia<1> Make() { return Sia<1>({.window_samples = 50, .integral_samples = 10}); }
  static constexpr int kSamplesOfAReading = 60;
  static constexpr double kSame = 1e-8;
};
struct InstrumentalShape {
  static InstrumentalSwa Make() { return InstrumentalSwa({.window_samples = 50}); }
  static constexpr int kSamplesOfAReading = 51;
  static constexpr double kSame = 0.05;  // its instruments remember more than the window
};

template <typename Shape>
class SlidingEstimator : public ::testing::Test {};
using Shapes = ::testing::Types<ArxShape, IntegralShape, InstrumentalShape>;
TYPED_TEST_SUITE(SlidingEstimator, Shapes);

template <typename Estimator>
void ExpectSame(const Estimator& one, const Estimator& other, double most, std::size_t k) {
  EXPECT_EQ(one.estimate().status, other.estimate().status) << k;
  for (std::size_t i = 0; i < one.estimate().theta.size(); ++i) {
    EXPECT_NEAR(one.estimate().theta[i], other.estimate().theta[i], most) << k << ", " << i;
  }
}

TYPED_TEST(SlidingEstimator, HoldsItsEstimateUnderConstantInputAndRecovers) {
  auto held = TypeParam::Make();
  auto fresh = TypeParam::Make();
  const Record before = MakeFirstOrder(MakeBinary(200, 1, 3), 0.0, 0.015, 3);
  for (std::size_t k = 0; k < before.u.size(); ++k) held.Push(before.u[k], before.y[k]);
  const auto last = held.estimate().theta;
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.015);
  for (int k = 0; k < 300; ++k) held.Push(2.0, 2.0 * testing::kB0 + noise(random));
  EXPECT_EQ(held.estimate().status, EstimateStatus::kNotExcited);
  EXPECT_GE(held.estimate().age_samples, 230);
  EXPECT_NEAR(held.estimate().theta[0], last[0], 1.0);
  const Record after = MakeFirstOrder(MakeBinary(300, 1, 4), 0.0, 0.015, 4);
  for (std::size_t k = 0; k < after.u.size(); ++k) {
    held.Push(after.u[k], after.y[k]);
    fresh.Push(after.u[k], after.y[k]);
  }
  EXPECT_EQ(held.estimate().status, EstimateStatus::kExcited);
  ExpectSame(held, fresh, TypeParam::kSame, after.u.size());
}

TYPED_TEST(SlidingEstimator, IsInvalidForExactlyTheSamplesWhoseWindowHoldsANonFiniteReading) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300}) {
    const Record record = MakeFirstOrder(MakeBinary(300, 1, 5), 0.0, 0.015, 5);
    auto struck = TypeParam::Make();
    auto clean = TypeParam::Make();
    constexpr std::size_t kFirst = 120;
    for (std::size_t k = 0; k < record.u.size(); ++k) {
      clean.Push(record.u[k], record.y[k]);
      struck.Push(record.u[k], k == kFirst ? bad : record.y[k]);
      if (k >= kFirst && k < kFirst + TypeParam::kSamplesOfAReading) {
        EXPECT_EQ(struck.estimate().status, EstimateStatus::kInvalid) << k;
      } else if (k >= kFirst) {
        ExpectSame(struck, clean, TypeParam::kSame, k);
      }
    }
  }
}

TYPED_TEST(SlidingEstimator, ForgetsAGlitchOnceItHasLeft) {
  const Record record = MakeFirstOrder(MakeBinary(600, 1, 6), 0.0, 0.015, 6);
  auto struck = TypeParam::Make();
  auto clean = TypeParam::Make();
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    clean.Push(record.u[k], record.y[k]);
    struck.Push(record.u[k], k == 120 ? 9e5 : record.y[k]);
  }
  EXPECT_EQ(struck.estimate().status, EstimateStatus::kExcited);
  ExpectSame(struck, clean, TypeParam::kSame, record.u.size());
}

/// Exact data: one row across the gap would leave residuals of volts.
TYPED_TEST(SlidingEstimator, BuildsNoRowAcrossAGapOrAClippedReading) {
  const Record record = MakeFirstOrder(MakeBinary(300, 1, 7), 0.0, 0.0, 7);
  auto estimator = TypeParam::Make();
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    if (k == 200) estimator.Skip(3);
    if (k >= 200 && k < 203) continue;
    if (k == 240) {
      estimator.PushUnusable();
    } else {
      estimator.Push(record.u[k], record.y[k]);
    }
    if (k > 120) {
      EXPECT_LT(estimator.estimate().sse, 1e-9) << k;
    }
  }
  EXPECT_EQ(estimator.estimate().status, EstimateStatus::kExcited);
}

TYPED_TEST(SlidingEstimator, AllocatesNothingWhileItRuns) {
  const Record record = MakeFirstOrder(MakeBinary(300, 1, 7), 0.0, 0.01, 7);
  auto estimator = TypeParam::Make();
  faultlab::testing::HeapGuard guard;
  for (std::size_t k = 0; k < record.u.size(); ++k) estimator.Push(record.u[k], record.y[k]);
  estimator.PushUnusable();
  estimator.Skip(3);
  EXPECT_EQ(guard.allocations(), 0);
}

}  // namespace
}  // namespace faultlab::core
