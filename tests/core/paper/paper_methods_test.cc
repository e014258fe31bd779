#include "core/paper/paper_methods.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/plant/coefficients.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

TEST(PaperMethods, JacobianHasTheCorrectedValuesOfEquation41) {
  const CoefficientJacobian jacobian = ContinuousJacobian(paper::Plant(), paper::Parts());
  EXPECT_NEAR(jacobian(0, 0), -6.4749e-3, 1e-6);
  EXPECT_NEAR(jacobian(1, 3), 2393.5, 0.1);
  EXPECT_NEAR(jacobian(2, 0), 2.1002e-3, 1e-6);
  EXPECT_NEAR(jacobian(2, 5), 1.2639e4, 1.0);
}

PaperMethods AtFault(Component component, double value) {
  const PlantParameters nominal = paper::Plant();
  PlantParameters faulty = paper::Plant();
  faulty.Set(component, value);
  const ContinuousTheta theta = FirstOrderTheta(nominal);
  return RunPaperMethods(paper::Bench(),
                         nominal,
                         theta,
                         FirstOrderTheta(faulty),
                         {0.01 * theta[0], 0.03 * theta[1], 0.03 * theta[2]});
}

TEST(PaperMethods, SingleColumnGivesTables11And12) {
  // Paper Tables 11 and 12, which were computed from exact parameters (see errata).
  const auto value = [](Component component, double fault) {
    return AtFault(component, fault)
        .single_column[static_cast<std::size_t>(Index(component))]
        .value;
  };
  EXPECT_NEAR(value(paper::kR1, 10.0), 9.8, 0.05);
  EXPECT_NEAR(value(paper::kR1, 56.0), 49.0, 0.5);
  EXPECT_NEAR(value(paper::kR1, 100.0), 79.0, 0.5);
  EXPECT_NEAR(value(paper::kR9, 33e3), 17e3, 100.0);
  EXPECT_NEAR(value(paper::kR9, 56e3), 18.2e3, 100.0);
  EXPECT_NEAR(value(paper::kR9, 100e3), 19e3, 100.0);
  EXPECT_NEAR(value(paper::kRa, 0.741), 0.62, 0.01);
  EXPECT_NEAR(value(paper::kB, 1.8e-4), 0.57e-4, 0.01e-4);
}

TEST(PaperMethods, ExactInversionHasNoLinearisationError) {
  for (const auto& [component, value] :
       std::vector<std::pair<Component, double>>{{paper::kR1, 100.0},
                                                 {paper::kR9, 33e3},
                                                 {paper::kR12, 2e3},
                                                 {paper::kC8, 10e-6},
                                                 {paper::kRa, 74.1},
                                                 {paper::kJ, 1.43e-4},
                                                 {paper::kB, 1.8e-4}}) {
    const PaperMethods methods = AtFault(component, value);
    const auto& exact = methods.exact[static_cast<std::size_t>(Index(component))];
    EXPECT_TRUE(exact.exists);
    EXPECT_NEAR(exact.value, value, 1e-4 * value) << Name(component);
  }
}

TEST(PaperMethods, FullJacobianHasRankThreeOfSeven) {
  const PaperMethods methods = AtFault(paper::kR1, 10.0);
  EXPECT_EQ(methods.full_jacobian_rank, 3);
  // The result of the pseudo-inverse is spread over all parts: far from the ten ohms.
  EXPECT_GT(std::abs(methods.full_jacobian_values[0] - 10.0), 2.0);
}

TEST(PaperMethods, DecisionPathEndsAtEachOfThePapersFaults) {
  const std::vector<std::pair<Component, double>> faults = {{paper::kR1, 10.0},
                                                            {paper::kR1, 100.0},
                                                            {paper::kR9, 33e3},
                                                            {paper::kR12, 2e3},
                                                            {paper::kC8, 1e-6},
                                                            {paper::kC8, 47e-6},
                                                            {paper::kRa, 0.741},
                                                            {paper::kRa, 74.1},
                                                            {paper::kJ, 1.43e-4},
                                                            {paper::kJ, 1.43e-8},
                                                            {paper::kB, 1.8e-4},
                                                            {paper::kB, 1.8e-5}};
  for (const auto& [component, value] : faults) {
    const PaperMethods methods = AtFault(component, value);
    EXPECT_NE(std::find(methods.named.begin(), methods.named.end(), component), methods.named.end())
        << Name(component) << " = " << value;
    ASSERT_GE(methods.path.size(), 2U);
    EXPECT_EQ(methods.path.back().components, methods.named);
  }
  const PlantParameters nominal = paper::Plant();
  const ContinuousTheta theta = FirstOrderTheta(nominal);
  EXPECT_TRUE(
      RunPaperMethods(paper::Bench(), nominal, theta, theta, {0.1, 0.1, 0.1}).named.empty());
}

}  // namespace
}  // namespace faultlab::core
