#include "core/estimators/swa.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/estimators/batch_oracle.h"
#include "tests/core/estimators/records.h"

namespace faultlab::core {
namespace {

using testing::MakeBinary;
using testing::MakeFirstOrder;
using testing::Record;

template <int Order, RowForm Form = RowForm::kPlain>
Swa<Order, Form> MakeSwa(int window, double noise_sigma_v = 0.0) {
  SwaOptions<Order, Form> options;
  options.window_samples = window;
  options.noise_sigma_v = noise_sigma_v;
  return Swa<Order, Form>(options);
}

TEST(Swa, FindsThePublishedDiscreteParametersOfTheNominalPlant) {
  // Paper Eq. (9) at the nominal Table 1: 2.1146, -1.0975, -0.5751 (to the digits printed).
  const Record record = MakeFirstOrder(MakeBinary(300, 1, 1), 0.0, 0.0, 1);
  Swa<1> swa = MakeSwa<1>(100);
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    swa.Push(record.u[k], record.y[k]);
  }
  EXPECT_NEAR(swa.estimate().theta[0], 2.1146, 1e-3);
  EXPECT_NEAR(swa.estimate().theta[1], -1.0975, 1e-3);
  EXPECT_NEAR(swa.estimate().theta[2], -0.5751, 1e-3);
  EXPECT_EQ(swa.estimate().status, EstimateStatus::kExcited);
}

/// A stable difference equation of order v, seeded; theta = b0..bv, a1..av.
template <int Order>
void ExpectTrueParametersWithoutNoise(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::array<double, 2 * Order + 1> truth;
  for (double& value : truth) {
    value = uniform(random) / Order;
  }
  truth[0] += 1.5;
  const std::vector<double> u = MakeBinary(400, 1, seed);
  std::vector<double> y(u.size());
  Swa<Order> swa = MakeSwa<Order>(80);
  for (std::size_t k = 0; k < u.size(); ++k) {
    for (std::size_t j = 0; j <= Order && j <= k; ++j) {
      y[k] += truth[j] * u[k - j] - (j > 0 ? truth[Order + j] * y[k - j] : 0.0);
    }
    swa.Push(u[k], y[k]);
  }
  const Estimate<2 * Order + 1>& answer = swa.estimate();
  ASSERT_NE(answer.status, EstimateStatus::kInvalid);
  for (std::size_t j = 0; j < truth.size(); ++j) {
    EXPECT_NEAR(answer.theta[j], truth[j], 1e-14 * answer.condition + 1e-9)
        << "order " << Order << " seed " << seed << " parameter " << j;
  }
}

TEST(Swa, FindsTheTrueParametersOfRandomSystemsOfOrderOneToThree) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    ExpectTrueParametersWithoutNoise<1>(seed);
    ExpectTrueParametersWithoutNoise<2>(seed);
    ExpectTrueParametersWithoutNoise<3>(seed);
  }
}

TEST(Swa, EqualsBatchQrOfItsOwnRowsUnderNoise) {
  const Record record = MakeFirstOrder(MakeBinary(500, 2, 4), 0.0095, 0.015, 4);
  Swa<2> swa = MakeSwa<2>(60);
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    swa.Push(record.u[k], record.y[k]);
  }
  std::vector<std::vector<double>> rows;
  for (std::size_t k = record.u.size() - 60; k < record.u.size(); ++k) {
    rows.push_back({record.u[k],
                    record.u[k - 1],
                    record.u[k - 2],
                    -record.y[k - 1],
                    -record.y[k - 2],
                    record.y[k]});
  }
  const testing::BatchAnswer batch = testing::SolveBatch(rows);
  for (std::size_t j = 0; j < 5; ++j) {
    EXPECT_NEAR(swa.estimate().theta[j], batch.theta[j], 1e-14 * batch.unit_condition);
    EXPECT_NEAR(swa.estimate().sigma[j], batch.sigma[j], 1e-6 * batch.sigma[j]);
  }
}

TEST(Swa, AbsorbsAConstantOffsetInItsAffineColumn) {
  const double offset_v = 0.4;
  const Record record = MakeFirstOrder(MakeBinary(300, 1, 2), 0.0, 0.0, 2, -offset_v);
  Swa<1, RowForm::kAffine> affine = MakeSwa<1, RowForm::kAffine>(100);
  Swa<1> plain = MakeSwa<1>(100);
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    affine.Push(record.u[k], record.y[k]);
    plain.Push(record.u[k], record.y[k]);
  }
  const double pole = std::exp(-testing::kPeriod_s / testing::kA1);
  EXPECT_NEAR(affine.estimate().theta[2], -pole, 1e-9);
  EXPECT_NEAR(affine.estimate().theta[3], -offset_v * (1.0 - pole), 1e-9);
  EXPECT_GT(std::abs(plain.estimate().theta[2] + pole), 1e-3);
}

TEST(Swa, StatesErrorsThatMatchTheScatterOfItsEstimates) {
  // Equation-error noise is white here, as the standard errors assume.
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 0.02);
  const std::vector<double> u = MakeBinary(40'000, 1, 11);
  Swa<1> swa = MakeSwa<1>(100);
  double y = 0.0;
  double u_before = 0.0;
  std::array<double, 3> squares{};
  std::array<double, 3> stated{};
  int windows = 0;
  const std::array<double, 3> truth = {2.1, -1.1, -0.57};
  for (std::size_t k = 0; k < u.size(); ++k) {
    y = truth[0] * u[k] + truth[1] * u_before - truth[2] * y + noise(random);
    u_before = u[k];
    swa.Push(u[k], y);
    if (k > 200 && k % 100 == 0) {
      ++windows;
      for (std::size_t j = 0; j < 3; ++j) {
        squares[j] += std::pow(swa.estimate().theta[j] - truth[j], 2);
        stated[j] += std::pow(swa.estimate().sigma[j], 2);
      }
    }
  }
  for (std::size_t j = 0; j < 3; ++j) {
    // 398 windows: the ratio of variances has a standard deviation of 7 %; four of these.
    EXPECT_NEAR(squares[j] / stated[j], 1.0, 0.28) << "parameter " << j << " of " << windows;
  }
}

TEST(Swa, LosesItsNoiseBiasWhenTheNoiseIsKnown) {
  const double noise_v = 0.03;
  const Record record = MakeFirstOrder(MakeBinary(60'000, 5, 12), 0.0, noise_v, 12);
  Swa<1> plain = MakeSwa<1>(200);
  Swa<1> compensated = MakeSwa<1>(200, noise_v);
  const double truth = -std::exp(-testing::kPeriod_s / testing::kA1);
  double plain_sum = 0.0;
  double compensated_sum = 0.0;
  int windows = 0;
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    plain.Push(record.u[k], record.y[k]);
    compensated.Push(record.u[k], record.y[k]);
    if (k > 400 && k % 200 == 0) {
      ++windows;
      plain_sum += plain.estimate().theta[2] - truth;
      compensated_sum += compensated.estimate().theta[2] - truth;
    }
  }
  const double plain_bias = plain_sum / windows / -truth;
  const double compensated_bias = compensated_sum / windows / -truth;
  EXPECT_GT(plain_bias, 0.04);
  EXPECT_LT(std::abs(compensated_bias), 0.2 * plain_bias);
}

}  // namespace
}  // namespace faultlab::core
