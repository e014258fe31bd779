#include "core/estimators/sliding_least_squares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <limits>
#include <random>

#include "tests/core/estimators/batch_oracle.h"
#include "tests/support/heap_guard.h"

namespace faultlab::core {
namespace {

using testing::BatchAnswer;
using testing::SolveBatch;

template <int P>
ExcitationGate<P> OpenGate() {
  ExcitationGate<P> gate;
  gate.absolute.fill(std::numeric_limits<double>::infinity());
  gate.condition_max = std::numeric_limits<double>::infinity();
  return gate;
}

TEST(SlidingLeastSquares, FitsALineInClosedForm) {
  // y = 1 + 2 x on x = 0, 1, 2, 3 with the residuals +1 -1 -1 +1: theta stays, sse = 4,
  // s^2 = 2, var(slope) = 2 / 5, var(intercept) = 2 (1/4 + 2.25 / 5).
  SlidingLeastSquares<2> fit(4, OpenGate<2>());
  const Estimate<2>* answer = nullptr;
  for (int x = 0; x < 4; ++x) {
    const double residual = x == 0 || x == 3 ? 1.0 : -1.0;
    answer = &fit.Push({1.0, static_cast<double>(x), 1.0 + 2.0 * x + residual});
  }
  EXPECT_NEAR(answer->theta[0], 1.0, 1e-13);
  EXPECT_NEAR(answer->theta[1], 2.0, 1e-13);
  EXPECT_NEAR(answer->sse, 4.0, 1e-12);
  EXPECT_NEAR(answer->sigma[0], std::sqrt(2.0 * (0.25 + 2.25 / 5.0)), 1e-12);
  EXPECT_NEAR(answer->sigma[1], std::sqrt(0.4), 1e-12);
  EXPECT_EQ(answer->status, EstimateStatus::kExcited);
}

TEST(SlidingLeastSquares, ReachesTheCertifiedValuesOfNorris) {
  // NIST Statistical Reference Datasets, linear regression, Norris: x, y and certified values.
  const std::vector<std::array<double, 2>> data = {
      {0.2, 0.1},     {337.4, 338.8}, {118.2, 118.1}, {884.6, 888.0}, {10.1, 9.2},
      {226.5, 228.1}, {666.3, 668.5}, {996.3, 998.5}, {448.6, 449.1}, {777.0, 778.9},
      {558.2, 559.2}, {0.4, 0.3},     {0.6, 0.1},     {775.5, 778.1}, {666.9, 668.8},
      {338.0, 339.3}, {447.5, 448.9}, {11.6, 10.8},   {556.0, 557.7}, {228.1, 228.3},
      {995.8, 998.0}, {887.6, 888.8}, {120.2, 119.6}, {0.3, 0.3},     {0.3, 0.6},
      {556.8, 557.6}, {339.1, 339.3}, {887.2, 888.0}, {999.0, 998.5}, {779.0, 778.9},
      {11.1, 10.2},   {118.3, 117.6}, {229.2, 228.9}, {669.1, 668.4}, {448.9, 449.2},
      {0.5, 0.2}};
  ASSERT_EQ(data.size(), 36u);
  SlidingLeastSquares<2> fit(36, OpenGate<2>());
  fit.Push({1.0, 4321.0, -999.0});  // leaves the window again
  for (const auto& [x, y] : data) {
    fit.Push({1.0, x, y});
  }
  const Estimate<2>& answer = fit.estimate();
  EXPECT_NEAR(answer.theta[0], -0.262323073774029, 1e-11);
  EXPECT_NEAR(answer.theta[1], 1.00211681802045, 1e-13);
  EXPECT_NEAR(answer.sigma[0], 0.232818234301152, 1e-9);
  EXPECT_NEAR(answer.sigma[1], 0.429796848199937e-03, 1e-12);
  EXPECT_NEAR(std::sqrt(answer.sse / 34.0), 0.884796396144373, 1e-9);
}

/// Rows with correlated columns of different size, as a slow plant produces them.
template <int P>
class CorrelatedRows {
 public:
  explicit CorrelatedRows(std::uint64_t seed) : random_(seed) {
    for (double& value : truth_) {
      value = value_(random_);
    }
  }
  std::array<double, P + 1> Next() {
    std::array<double, P + 1> row;
    common_ = 0.9 * common_ + value_(random_);
    double y = 0.02 * value_(random_);
    for (std::size_t j = 0; j < P; ++j) {
      row[j] = (0.3 * value_(random_) + common_ + 1.0) * std::pow(10.0, static_cast<double>(j) - 1);
      y += truth_[j] * row[j];
    }
    row[P] = y;
    return row;
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> value_;
  std::array<double, P> truth_;
  double common_ = 0.0;
};

template <int P>
void ExpectBatchAnswer(const Estimate<P>& estimate,
                       const std::deque<std::array<double, P + 1>>& window,
                       const char* where) {
  std::vector<std::vector<double>> rows;
  for (const auto& row : window) {
    rows.emplace_back(row.begin(), row.end());
  }
  const BatchAnswer batch = SolveBatch(rows);
  // Normal equations lose condition * 1e-16 of theta; factor 100 for sums and factorisation.
  const double loss = 1e-14 * batch.unit_condition;
  // sse is the remainder of sum y^2, so it has a rounding error of that size.
  const double sse_error = 1e-12 * batch.sum_of_squares;
  for (std::size_t j = 0; j < P; ++j) {
    EXPECT_NEAR(estimate.theta[j], batch.theta[j], loss * batch.scale[j]) << where;
    EXPECT_NEAR(estimate.sigma[j], batch.sigma[j], (loss + sse_error / batch.sse) * batch.sigma[j])
        << where;
  }
  EXPECT_NEAR(estimate.sse, batch.sse, sse_error) << where;
  EXPECT_GE(estimate.condition, batch.unit_condition * (1.0 - 1e-6)) << where;
  EXPECT_LE(estimate.condition, P * batch.unit_condition * (1.0 + 1e-6)) << where;
}

template <int P>
void ExpectBatchAnswersOnRandomProblems(int window_samples) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    CorrelatedRows<P> source(seed);
    SlidingLeastSquares<P> fit(window_samples, OpenGate<P>());
    std::deque<std::array<double, P + 1>> window;
    for (int k = 0; k < 3 * window_samples + 5; ++k) {
      window.push_back(source.Next());
      fit.Push(window.back());
      if (static_cast<int>(window.size()) > window_samples) {
        window.pop_front();
      }
      if (k >= window_samples && k % 17 == 0) {
        ASSERT_NO_FATAL_FAILURE(ExpectBatchAnswer<P>(fit.estimate(), window, "random problem"));
      }
    }
  }
}

TEST(SlidingLeastSquares, AgreesWithBatchQrOnRandomProblemsOfTwoToSixParameters) {
  ExpectBatchAnswersOnRandomProblems<2>(12);
  ExpectBatchAnswersOnRandomProblems<3>(50);
  ExpectBatchAnswersOnRandomProblems<4>(50);
  ExpectBatchAnswersOnRandomProblems<5>(100);
  ExpectBatchAnswersOnRandomProblems<6>(100);
}

TEST(SlidingLeastSquares, AgreesWithBatchQrAfterAMillionSteps) {
  CorrelatedRows<3> source(99);
  SlidingLeastSquares<3> fit(100, OpenGate<3>());
  std::deque<std::array<double, 4>> window;
  for (int k = 0; k < 1'000'050; ++k) {
    const std::array<double, 4> row = source.Next();
    fit.Push(row);
    if (k >= 1'000'050 - 100) {
      window.push_back(row);
    }
  }
  ExpectBatchAnswer<3>(fit.estimate(), window, "after 1e6 steps");
}

TEST(SlidingLeastSquares, HoldsTheLastThetaAndItsAgeWhileNothingExcitesIt) {
  CorrelatedRows<3> source(5);
  ExcitationGate<3> gate = OpenGate<3>();
  gate.condition_max = kConditionMax;
  SlidingLeastSquares<3> fit(20, gate);
  for (int k = 0; k < 40; ++k) {
    fit.Push(source.Next());
  }
  ASSERT_EQ(fit.estimate().status, EstimateStatus::kExcited);
  std::array<double, 3> last{};
  int held = 0;
  for (int k = 0; k < 200; ++k) {
    const Estimate<3>& now = fit.Push({3.0, 3.0, -7.2, 7.2});
    if (now.status == EstimateStatus::kNotExcited) {
      EXPECT_EQ(now.theta, last);
      EXPECT_EQ(now.age_samples, ++held);
      EXPECT_TRUE(std::isnan(now.sigma[0]));
      EXPECT_GE(now.condition, kConditionMax);
    } else {
      EXPECT_EQ(now.age_samples, 0);
      last = now.theta;
    }
  }
  EXPECT_GE(held, 200 - 20);
  for (int k = 0; k < 40; ++k) {
    fit.Push(source.Next());
  }
  EXPECT_EQ(fit.estimate().status, EstimateStatus::kExcited);
  EXPECT_EQ(fit.estimate().age_samples, 0);
}

TEST(SlidingLeastSquares, CallsAnEstimateWeakWhenAnErrorExceedsItsTolerance) {
  ExcitationGate<3> gate = OpenGate<3>();
  gate.absolute[1] = 1e-6;
  CorrelatedRows<3> source(6);
  SlidingLeastSquares<3> fit(30, gate);
  for (int k = 0; k < 60; ++k) {
    fit.Push(source.Next());
  }
  EXPECT_EQ(fit.estimate().status, EstimateStatus::kWeak);
  EXPECT_GT(fit.estimate().sigma[1], 1e-6);
  EXPECT_EQ(fit.estimate().age_samples, 0);
}

TEST(SlidingLeastSquares, IsInvalidUntilFullAndWhileAnInvalidRowIsInside) {
  CorrelatedRows<3> source(8);
  SlidingLeastSquares<3> fit(10, OpenGate<3>());
  for (int k = 0; k < 9; ++k) {
    EXPECT_EQ(fit.Push(source.Next()).status, EstimateStatus::kInvalid);
    EXPECT_TRUE(std::isnan(fit.estimate().theta[0]));
  }
  EXPECT_EQ(fit.Push(source.Next()).status, EstimateStatus::kExcited);
  EXPECT_EQ(fit.PushEmpty(RowKind::kInvalid).status, EstimateStatus::kInvalid);
  for (int k = 0; k < 9; ++k) {
    EXPECT_EQ(fit.Push(source.Next()).status, EstimateStatus::kInvalid);
    EXPECT_EQ(fit.estimate().age_samples, k + 2);
  }
  EXPECT_EQ(fit.Push(source.Next()).status, EstimateStatus::kExcited);
}

TEST(SlidingLeastSquares, EstimatesFromTheRowsThatAGapLeft) {
  CorrelatedRows<3> source(9);
  SlidingLeastSquares<3> fit(20, OpenGate<3>());
  std::deque<std::array<double, 4>> window;
  for (int k = 0; k < 40; ++k) {
    window.push_back(source.Next());
    fit.Push(window.back());
  }
  fit.Skip(5);
  for (int k = 0; k < 3; ++k) {
    window.push_back(source.Next());
    fit.Push(window.back());
  }
  while (window.size() > 15) {
    window.pop_front();
  }
  EXPECT_EQ(fit.moments().rows(), 15);
  EXPECT_EQ(fit.estimate().status, EstimateStatus::kExcited);
  ExpectBatchAnswer<3>(fit.estimate(), window, "after a gap");
}

TEST(SlidingLeastSquares, StartsAnewAfterAGapOfAWholeWindow) {
  CorrelatedRows<3> source(10);
  SlidingLeastSquares<3> fit(20, OpenGate<3>());
  for (int k = 0; k < 40; ++k) {
    fit.Push(source.Next());
  }
  fit.Skip(2'000'000'000);
  EXPECT_EQ(fit.moments().rows(), 0);
  EXPECT_EQ(fit.Push(source.Next()).status, EstimateStatus::kInvalid);
  EXPECT_EQ(fit.estimate().age_samples, 2'000'000'001);
  fit.Skip(2'000'000'000);
  EXPECT_EQ(fit.estimate().age_samples, std::numeric_limits<std::int32_t>::max());
}

TEST(SlidingLeastSquares, AllocatesNothingWhileItRuns) {
  CorrelatedRows<5> source(11);
  SlidingLeastSquares<5> fit(50, OpenGate<5>());
  faultlab::testing::HeapGuard guard;
  for (int k = 0; k < 500; ++k) {
    fit.Push(source.Next());
  }
  fit.PushEmpty(RowKind::kInvalid);
  fit.Skip(100);
  EXPECT_EQ(guard.allocations(), 0);
}

TEST(SlidingLeastSquares, SaysThatThereIsNothingLeftWhenTheNoiseExplainsEveryRow) {
  CorrelatedRows<3> source(12);
  SlidingLeastSquares<3> fit(20, OpenGate<3>());
  SlidingMoments<4>::Packed more_than_all{};
  for (int i = 0; i < 3; ++i) {
    more_than_all[PackedIndex(i, i)] = 1e6;
  }
  fit.CompensateNoise(more_than_all);
  for (int k = 0; k < 25; ++k) {
    fit.Push(source.Next());
  }
  EXPECT_EQ(fit.estimate().status, EstimateStatus::kNotExcited);
  EXPECT_TRUE(std::isnan(fit.estimate().sse));
  EXPECT_TRUE(std::isnan(fit.estimate().theta[0]));
}

TEST(SlidingLeastSquares, RefusesAWindowThatCannotDetermineItsParameters) {
  EXPECT_THROW(SlidingLeastSquares<3>(3, OpenGate<3>()), ContractError);
}

}  // namespace
}  // namespace faultlab::core
