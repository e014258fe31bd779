#include "core/estimators/instrumental_swa.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/estimators/records.h"

namespace faultlab::core {
namespace {

using testing::MakeBinary;
using testing::MakeFirstOrder;
using testing::Record;

InstrumentalSwa::Options Window(int samples) {
  InstrumentalSwa::Options options;
  options.window_samples = samples;
  return options;
}

TEST(InstrumentalSwa, FindsThePublishedParametersWithoutNoise) {
  const Record record = MakeFirstOrder(MakeBinary(400, 1, 1), 0.0, 0.0, 1, 0.25);
  InstrumentalSwa swa(Window(100));
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    swa.Push(record.u[k], record.y[k]);
  }
  const double pole = std::exp(-testing::kPeriod_s / testing::kA1);
  EXPECT_NEAR(swa.estimate().theta[0], 2.1146, 1e-3);
  EXPECT_NEAR(swa.estimate().theta[1], -1.0975, 1e-3);
  EXPECT_NEAR(swa.estimate().theta[2], -pole, 1e-8);
  EXPECT_NEAR(swa.estimate().theta[3], 0.25 * (1.0 - pole), 1e-8);
  EXPECT_EQ(swa.estimate().status, EstimateStatus::kExcited);
}

TEST(InstrumentalSwa, IsFreeOfTheNoiseBiasOfLeastSquares) {
  const double noise_v = 0.03;
  const Record record = MakeFirstOrder(MakeBinary(60'000, 5, 12), 0.0, noise_v, 12);
  InstrumentalSwa instrumental(Window(200));
  Swa<1, RowForm::kAffine> ordinary(Window(200));
  const double truth = -std::exp(-testing::kPeriod_s / testing::kA1);
  double instrumental_sum = 0.0;
  double ordinary_sum = 0.0;
  int windows = 0;
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    instrumental.Push(record.u[k], record.y[k]);
    ordinary.Push(record.u[k], record.y[k]);
    if (k > 1000 && k % 200 == 0) {
      ++windows;
      instrumental_sum += instrumental.estimate().theta[2] - truth;
      ordinary_sum += ordinary.estimate().theta[2] - truth;
    }
  }
  EXPECT_GT(ordinary_sum / windows, 0.04 * -truth);
  EXPECT_LT(std::abs(instrumental_sum), 0.2 * ordinary_sum);
}

}  // namespace
}  // namespace faultlab::core
