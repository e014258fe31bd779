#include "core/paper/model_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/paper/window_study.h"
#include "core/signals/prbs.h"
#include "core/signals/random.h"

namespace faultlab::core {
namespace {

constexpr double kPeriodS = 0.01;

/// y by `equation` and white noise of its rows, um in volts.
std::vector<Sample> Simulate(const DifferenceEquation& equation, double noise_v, int samples) {
  const std::vector<double> u =
      MakePrbs({.low_v = 1.0, .high_v = 3.0, .clock_s = 0.05, .seed = 3}, samples, kPeriodS);
  Random random(5);
  std::vector<Sample> record(u.size());
  for (std::size_t k = 0; k < u.size(); ++k) {
    Sample& sample = record[k];
    sample.index = static_cast<std::int64_t>(k);
    sample.t_s = kPeriodS * static_cast<double>(k);
    sample.uc_v = u[k];
    double y = equation.offset + noise_v * random.Normal();
    for (std::size_t i = 0; i < equation.b.size() && i <= k; ++i) y += equation.b[i] * u[k - i];
    for (std::size_t i = 0; i < equation.a.size() && i < k; ++i) {
      y -= equation.a[i] * record[k - 1 - i].um_v;
    }
    sample.um_v = y;
  }
  return record;
}

// Poles 0.9 and 0.5.
const DifferenceEquation kSecond{{0.04, 0.02, 0.01}, {-1.4, 0.45}, 0.0};

VariantSpec Spec(EstimatorMethod method, int order) {
  VariantSpec spec;
  spec.method = method;
  spec.order = order;
  spec.window_samples = 400;
  spec.integral_samples = method == EstimatorMethod::kSia ? 10 : 0;
  return spec;
}

TEST(ModelOrder, SiasRuleIsAForwardDifference) {
  VariantSpec spec = Spec(EstimatorMethod::kSia, 1);
  const DifferenceEquation first = DifferenceOf(spec, std::vector<double>{2.0, 0.3, 0.05});
  EXPECT_DOUBLE_EQ(first.a[0], kPeriodS / 0.05 - 1.0);
  EXPECT_DOUBLE_EQ(first.b[0], 0.3 / 0.05);
  EXPECT_DOUBLE_EQ(first.b[1], (2.0 * kPeriodS - 0.3) / 0.05);
  // A constant input ends at b0 times it, whatever the order.
  spec = Spec(EstimatorMethod::kSia, 3);
  spec.affine = true;
  const DifferenceEquation third =
      DifferenceOf(spec, std::vector<double>{2.0, 0.3, 1e-3, 1e-5, 0.1, 3e-3, 4e-5, 0.7});
  double b = third.offset;
  double a = 1.0;
  for (const double each : third.b) b += each;
  for (const double each : third.a) a += each;
  EXPECT_NEAR(b / a, 2.0 + 0.7, 1e-9);
}

TEST(ModelOrder, OfTheEquationThatMadeTheRecordTheNoiseIsLeftAndWhite) {
  const std::vector<Sample> record = Simulate(kSecond, 0.02, 4000);
  const VariantSpec spec = Spec(EstimatorMethod::kSwa, 2);
  std::vector<double> theta = kSecond.b;
  theta.insert(theta.end(), kSecond.a.begin(), kSecond.a.end());
  const OrderEvidence left = JudgeOrder(spec, theta, record);
  EXPECT_EQ(left.count, 4000 - kOrderMax);
  EXPECT_NEAR(left.rms, 0.02, 0.001);
  EXPECT_TRUE(left.white()) << left.ljung_box << " of " << left.white_below;
  EXPECT_NEAR(left.white_below, 28.87, 0.05) << "chi-square of 18, 95 %";
}

TEST(ModelOrder, IsFoundByWhatEachOrderLeaves) {
  // Noise of the rows is white to SWA, and biases the integrals of SIA.
  for (const EstimatorMethod method : {EstimatorMethod::kSwa, EstimatorMethod::kSia}) {
    const bool swa = method == EstimatorMethod::kSwa;
    std::vector<Sample> record = Simulate(kSecond, swa ? 0.02 : 1e-6, 4000);
    std::vector<VariantSpec> specs;
    for (int order = 1; order <= kOrderMax; ++order) specs.push_back(Spec(method, order));
    const auto rows = StudyWindows(record, 0, record.size(), specs, Curves::kDropped).value();
    SCOPED_TRACE(rows[0].name);
    EXPECT_TRUE(rows[0].estimates.empty());
    const OrderEvidence& first = rows[0].left_before;
    const OrderEvidence& second = rows[1].left_before;
    EXPECT_EQ(first.count, second.count) << "the same rows";
    EXPECT_FALSE(first.white());
    EXPECT_LT(second.rms, 0.9 * first.rms);
    EXPECT_LT(second.bic, first.bic);
    if (!swa) continue;
    EXPECT_TRUE(second.white()) << second.ljung_box;
    EXPECT_LT(second.bic, rows[2].left_before.bic);
    EXPECT_LT(second.bic, rows[3].left_before.bic);
  }
}

TEST(ModelOrder, RowsBehindAGapHaveNoResidual) {
  std::vector<Sample> record = Simulate(kSecond, 0.02, 200);
  record[50].um_v = kAbsent;
  record.erase(record.begin() + 100);
  std::vector<double> theta = kSecond.b;
  theta.insert(theta.end(), kSecond.a.begin(), kSecond.a.end());
  const VariantSpec spec = Spec(EstimatorMethod::kSwa, 2);
  EXPECT_EQ(JudgeOrder(spec, theta, record).count, 199 - kOrderMax - (1 + kOrderMax) - kOrderMax);
  const OrderEvidence few = JudgeOrder(spec, theta, std::span(record).first(43));
  EXPECT_TRUE(std::isnan(few.bic));
  EXPECT_FALSE(few.white());
}

}  // namespace
}  // namespace faultlab::core
