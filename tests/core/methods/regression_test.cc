#include "core/methods/regression.h"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <cmath>

#include "core/methods/hypotheses.h"
#include "core/methods/method_session.h"
#include "tests/core/bench_records.h"

namespace faultlab::core {
namespace {

MethodTask TaskOf(const std::vector<Sample>& record) {
  return PrepareMethods(record, MethodOptionsOf(paper::Bench(), paper::kPeriodS)).value();
}

TEST(CoefficientMap, FindsTheValueThatMadeItsCoefficients) {
  const MethodTask task = TaskOf(BenchRecord({}, 3, 6.0));
  CoefficientMap map(task, std::make_unique<DiscreteEquation>());
  const Eigen::Matrix3d information = 1e6 * Eigen::Matrix3d::Identity();
  for (const auto& [component, value] :
       {std::pair{paper::kR1, 30.0}, {paper::kC8, 5e-6}, {paper::kJ, 8e-6}, {paper::kB, 4e-5}}) {
    const MethodFinding finding = map.Match(map.At(component, std::log(value)), information);
    ASSERT_EQ(finding.isolation, Answer::kGiven);
    EXPECT_EQ(Name(finding.candidates.front().component), Name(component));
    EXPECT_NEAR(finding.candidates.front().value / value, 1.0, 1e-3);
  }
}

TEST(CoefficientMap, NamesBothResistorsOfTheGain) {
  const MethodTask task = TaskOf(BenchRecord({}, 3, 6.0));
  CoefficientMap map(task, std::make_unique<DiscreteEquation>());
  const MethodFinding finding =
      map.Match(map.At(paper::kR9, std::log(33e3)), 1e6 * Eigen::Matrix3d::Identity());
  ASSERT_EQ(finding.named, 2U);
  for (const MethodCandidate& candidate : std::span(finding.candidates).first(2)) {
    const double expected = candidate.component == paper::kR9 ? 33e3 : 5818.0;  // the same gain
    EXPECT_NEAR(candidate.value / expected, 1.0, 0.01) << Name(candidate.component);
  }
}

TEST(DistinctComponents, LeavesOutWhatNoReadingSeparates) {
  const std::vector<Component> distinct = DistinctComponents(TaskOf(BenchRecord({}, 3, 6.0)));
  std::string names;
  for (const Component component : distinct) names += std::string(Name(component)) + " ";
  EXPECT_EQ(names, "R1 R9 C8 Ra J B La ");
}

TEST(NormalSums, WithoutConstantIsTheInformationOfTheOthers) {
  NormalSums sums;
  for (int k = 0; k < 20; ++k) {
    EquationRow row;
    row << std::sin(k), std::cos(2.0 * k), 0.1 * k, 1.0, 2.0 * std::sin(k) + 0.3 * k - 1.0;
    sums.Add(row);
  }
  const EquationVector theta = sums.Solve();
  EXPECT_NEAR(theta(0), 2.0, 1e-9);
  EXPECT_NEAR(theta(1), 0.0, 1e-9);
  EXPECT_NEAR(theta(2), 3.0, 1e-9);
  EXPECT_NEAR(theta(3), -1.0, 1e-9);
  const Eigen::Matrix3d reduced = WithoutConstant(sums.information());
  const EquationMatrix covariance =
      sums.information().fullPivLu().solve(EquationMatrix::Identity());
  const Eigen::Matrix3d product = reduced * covariance.topLeftCorner<3, 3>();
  EXPECT_TRUE(product.isApprox(Eigen::Matrix3d::Identity(), 1e-9)) << product;
}

}  // namespace
}  // namespace faultlab::core
