#include "core/estimators/sia.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/estimators/batch_oracle.h"
#include "tests/core/estimators/records.h"

namespace faultlab::core {
namespace {

using testing::kA1;
using testing::kB0;
using testing::kB1;
using testing::kPeriod_s;
using testing::MakeBinary;
using testing::MakeFirstOrder;
using testing::Record;

SiaOptions<1> Options(int window, int integral, SiaMode mode = SiaMode::kPaper, double delta = 0) {
  SiaOptions<1> options;
  options.window_samples = window;
  options.integral_samples = integral;
  options.mode = mode;
  options.delta_s = delta;
  return options;
}

template <typename Estimator>
const auto& Play(Estimator& estimator, const Record& record) {
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    estimator.Push(record.u[k], record.y[k]);
  }
  return estimator.estimate();
}

TEST(Sia, ReadsThePaperModesBiasedTimeConstantInClosedForm) {
  // a1' = T / (1 - exp(-T/a1)) = 0.02353, b1' = b1 a1' / a1 = 0.0498; b0 unbiased.
  const Record record = MakeFirstOrder(MakeBinary(400, 1, 1), 0.0, 0.0, 1);
  for (const auto& [window, integral] : {std::pair{20, 5}, {100, 20}, {100, 1}}) {
    Sia<1> sia(Options(window, integral));
    const Estimate<3>& answer = Play(sia, record);
    const double a1_paper = kPeriod_s / (1.0 - std::exp(-kPeriod_s / kA1));
    EXPECT_NEAR(answer.theta[0], kB0, 1e-8);
    EXPECT_NEAR(answer.theta[1], kB1 * a1_paper / kA1, 1e-9);
    EXPECT_NEAR(answer.theta[2], a1_paper, 1e-9);
  }
  EXPECT_NEAR(kPeriod_s / (1.0 - std::exp(-kPeriod_s / kA1)), 0.02353, 1e-5);
}

TEST(Sia, RecoversTheContinuousParametersInExactModeForEveryReadingDelay) {
  for (const double delta_s : {0.0, 4.5e-3, 9.5e-3, 10e-3}) {
    const Record record = MakeFirstOrder(MakeBinary(400, 1, 2), delta_s, 0.0, 2);
    Sia<1> sia(Options(100, 20, SiaMode::kExact, delta_s));
    const Estimate<3>& answer = Play(sia, record);
    EXPECT_NEAR(answer.theta[0], kB0, 1e-8) << delta_s;
    EXPECT_NEAR(answer.theta[1], kB1, 1e-9) << delta_s;
    EXPECT_NEAR(answer.theta[2], kA1, 1e-9) << delta_s;
    EXPECT_EQ(answer.status, EstimateStatus::kExcited);
  }
}

TEST(Sia, PropagatesItsErrorsThroughTheExactMapping) {
  // Compared with numerical derivatives of the mapping, applied to the result in paper mode.
  const double delta_s = 9.5e-3;
  const Record record = MakeFirstOrder(MakeBinary(700, 1, 3), delta_s, 0.015, 3);
  Sia<1> exact(Options(500, 20, SiaMode::kExact, delta_s));
  const Estimate<3>& answer = Play(exact, record);

  std::vector<std::vector<double>> rows;
  NestedIntegrals<1> u(20, kPeriod_s);
  NestedIntegrals<1> y(20, kPeriod_s);
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    const auto ru = u.Push(record.u[k]);
    const auto ry = y.Push(record.y[k]);
    if (k >= record.u.size() - 500) {
      rows.push_back({ru[0], ru[1], -ry[1], ry[0]});
    }
  }
  const auto map = [&](const std::vector<double>& p) {
    const double a1 = -kPeriod_s / std::log(1.0 - kPeriod_s / p[2]);
    return std::array<double, 3>{
        p[0], a1 * (p[0] - (p[0] - p[1] / p[2]) * std::exp(delta_s / a1)), a1};
  };
  const testing::BatchAnswer batch = testing::SolveBatch(rows);
  // The covariance along each direction, by perturbing y by one row's share: d theta = sum_k (d
  // theta / d y_k) e, with white e of variance sse/(n-p).
  std::array<double, 3> variance{};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::vector<std::vector<double>> moved = rows;
    const double step = 1e-4;
    moved[k][3] += step;
    const auto high = map(testing::SolveBatch(moved).theta);
    moved[k][3] -= 2.0 * step;
    const auto low = map(testing::SolveBatch(moved).theta);
    for (std::size_t j = 0; j < 3; ++j) {
      variance[j] += std::pow((high[j] - low[j]) / (2.0 * step), 2) * batch.sse / 497.0;
    }
  }
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_NEAR(answer.sigma[j], std::sqrt(variance[j]), 1e-3 * std::sqrt(variance[j])) << j;
  }
}

TEST(Sia, SaysWhenTheTimeConstantIsTooShortToResolve) {
  // y = b0 u at once: a1' = T exactly, with noise on either side of it.
  std::mt19937_64 random(4);
  std::normal_distribution<double> noise(0.0, 0.01);
  Sia<1> sia(Options(100, 20, SiaMode::kExact, 9.5e-3));
  int unresolved = 0;
  double u_before = 2.0;
  for (const double u : MakeBinary(2000, 1, 4)) {
    const Estimate<3>& answer = sia.Push(u, 2.4 * u_before + noise(random));
    u_before = u;
    if (answer.status == EstimateStatus::kInvalid || answer.theta[2] != 0.0) {
      continue;
    }
    ++unresolved;
    EXPECT_EQ(answer.status, EstimateStatus::kWeak);
    EXPECT_TRUE(std::isinf(answer.sigma[1]));
    EXPECT_TRUE(std::isfinite(answer.sigma[2]));
    EXPECT_NEAR(answer.theta[0], 2.4, 0.05);
  }
  EXPECT_GT(unresolved, 100);
}

template <int Order, RowForm Form>
void ExpectBatchOfPolynomialRows(int window, int m) {
  const Record record = MakeFirstOrder(MakeBinary(600, 2, 5), 0.0095, 0.015, 5, 0.2);
  SiaOptions<Order, Form> options;
  options.window_samples = window;
  options.integral_samples = m;
  Sia<Order, Form> sia(options);
  std::vector<std::vector<double>> rows;
  NestedIntegrals<Order> u(m, kPeriod_s);
  NestedIntegrals<Order> y(m, kPeriod_s);
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    sia.Push(record.u[k], record.y[k]);
    const auto ru = u.Push(record.u[k]);
    const auto ry = y.Push(record.y[k]);
    if (k >= record.u.size() - static_cast<std::size_t>(window)) {
      std::vector<double>& row = rows.emplace_back(ru.begin(), ru.end());
      for (std::size_t j = 1; j <= Order; ++j) {
        row.push_back(-ry[j]);
      }
      if (Form == RowForm::kAffine) {
        row.push_back(std::pow(kPeriod_s * m, Order));
      }
      row.push_back(ry[0]);
    }
  }
  const testing::BatchAnswer batch = testing::SolveBatch(rows);
  ASSERT_EQ(batch.theta.size(), static_cast<std::size_t>(Sia<Order, Form>::kParameters));
  for (std::size_t j = 0; j < batch.theta.size(); ++j) {
    EXPECT_NEAR(
        sia.estimate().theta[j], batch.theta[j], 1e-14 * batch.unit_condition * batch.scale[j])
        << "order " << Order << " parameter " << j;
  }
}

TEST(Sia, EqualsBatchQrOfItsRowsInOrderOneAndTwoWithAndWithoutConstant) {
  ExpectBatchOfPolynomialRows<1, RowForm::kPlain>(100, 20);
  ExpectBatchOfPolynomialRows<1, RowForm::kAffine>(100, 20);
  ExpectBatchOfPolynomialRows<2, RowForm::kPlain>(200, 10);
  ExpectBatchOfPolynomialRows<2, RowForm::kAffine>(200, 10);
}

TEST(Sia, OfOrderTwoTendsToTheContinuousModelWhenSampledFast) {
  // (b2 s^2 + b1 s + b0)/(a2 s^2 + a1 s + 1) as the sum of two first-order lags, T = 0.1 ms.
  const double period_s = 1e-4;
  const double tau1 = 0.03;
  const double tau2 = 0.008;
  const double g1 = 1.4;
  const double g2 = 0.7;
  SiaOptions<2> options;
  options.window_samples = 4000;
  options.integral_samples = 100;
  options.period_s = period_s;
  Sia<2> sia(options);
  double w1 = 0.0;
  double w2 = 0.0;
  for (const double u : MakeBinary(8000, 60, 6)) {
    sia.Push(u, g1 * w1 + g2 * w2 + 0.3 * u);
    w1 = u + (w1 - u) * std::exp(-period_s / tau1);
    w2 = u + (w2 - u) * std::exp(-period_s / tau2);
  }
  const Estimate<5>& answer = sia.estimate();
  const double a1 = tau1 + tau2;
  const double a2 = tau1 * tau2;
  EXPECT_NEAR(answer.theta[0], g1 + g2 + 0.3, 0.01);
  EXPECT_NEAR(answer.theta[1], g1 * tau2 + g2 * tau1 + 0.3 * a1, 0.02 * 0.044);
  EXPECT_NEAR(answer.theta[2], 0.3 * a2, 0.05 * 0.3 * a2);
  EXPECT_NEAR(answer.theta[3], a1, 0.02 * a1);
  EXPECT_NEAR(answer.theta[4], a2, 0.05 * a2);
}

TEST(Sia, LosesItsNoiseBiasWhenTheNoiseIsKnown) {
  const double noise_v = 0.03;
  const Record record = MakeFirstOrder(MakeBinary(60'000, 1, 7), 0.0, noise_v, 7);
  SiaOptions<1> options = Options(500, 20);
  Sia<1> plain(options);
  options.noise_sigma_v = noise_v;
  Sia<1> compensated(options);
  const double truth = kPeriod_s / (1.0 - std::exp(-kPeriod_s / kA1));
  double plain_sum = 0.0;
  double compensated_sum = 0.0;
  int windows = 0;
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    plain.Push(record.u[k], record.y[k]);
    compensated.Push(record.u[k], record.y[k]);
    if (k > 1000 && k % 500 == 0) {
      ++windows;
      plain_sum += plain.estimate().theta[2] - truth;
      compensated_sum += compensated.estimate().theta[2] - truth;
    }
  }
  EXPECT_GT(std::abs(plain_sum / windows), 0.005 * truth);
  EXPECT_LT(std::abs(compensated_sum), 0.3 * std::abs(plain_sum));
}

TEST(Sia, RefusesAnIntegralAsLongAsItsWindow) {
  EXPECT_THROW(Sia<1>(Options(20, 20)), ContractError);
}

}  // namespace
}  // namespace faultlab::core
