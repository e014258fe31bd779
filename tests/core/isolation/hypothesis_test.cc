#include "core/isolation/hypothesis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/isolation/fault_stretch.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

HypothesisFit StartAt(Component component, double value) {
  HypothesisFit fit;
  fit.component = component;
  fit.exists = true;
  fit.value = value;
  return fit;
}

TEST(Hypothesis, OfTheRightComponentFindsItsValueAndLeavesOnlyNoise) {
  FaultStretch fault({AbruptFault(paper::kRa, 12.0, 1.0)}, 101, 0.002);
  HypothesisFit fit = StartAt(paper::kRa, 10.0);
  RefineComponent(fault.context, fit);
  EXPECT_NEAR(std::log(fit.value / 12.0), 0.0, 4.0 * fit.log_sigma);
  EXPECT_LT(fit.log_sigma, 0.02);
  EXPECT_EQ(fit.bound, 0);
  EXPECT_EQ(fit.count, 600);
  // 600 readings: chi2/n has a standard deviation of 6 %.
  EXPECT_NEAR(fit.chi2 / fit.count, 1.0, 0.3);
}

TEST(Hypothesis, OfNoFaultCostsMoreTheMoreTheFaultShows) {
  FaultStretch healthy({}, 102);
  FaultStretch faulty({AbruptFault(paper::kRa, 12.0, 1.0)}, 102);
  const HypothesisFit null_healthy = FitNullHypothesis(healthy.context);
  const HypothesisFit null_faulty = FitNullHypothesis(faulty.context);
  HypothesisFit fit = StartAt(paper::kRa, 12.0);
  RefineComponent(faulty.context, fit);
  EXPECT_LT(null_healthy.chi2 / null_healthy.count, 1.3);
  EXPECT_GT(null_faulty.cost, fit.cost + 1000.0);
}

TEST(Hypothesis, AtAGivenValueIsNoBetterThanTheFreeFit) {
  FaultStretch fault({AbruptFault(paper::kR1, 10.0, 1.0)}, 103);
  HypothesisFit fit = StartAt(paper::kR1, 10.0);
  RefineComponent(fault.context, fit);
  EXPECT_NEAR(FitComponentAt(fault.context, paper::kR1, fit.value).cost, fit.cost, 0.5);
  const double away = fit.value * std::exp(5.0 * fit.log_sigma);
  EXPECT_GT(FitComponentAt(fault.context, paper::kR1, away).cost, fit.cost + 9.0);
}

TEST(Hypothesis, TellsABoundForAnInertiaThatIsTooSmallToSee) {
  FaultStretch fault({AbruptFault(paper::kJ, 1.43e-8, 1.0)}, 104, 0.01, Channels::kUmOnly);
  HypothesisFit fit = StartAt(paper::kJ, 5e-8);
  RefineComponent(fault.context, fit);
  EXPECT_EQ(fit.bound, '<');
  EXPECT_GT(fit.value, 1.43e-8);
  EXPECT_LT(fit.value, 1e-6);
}

TEST(Hypothesis, FollowsAValueThatMoves) {
  Fault drift = AbruptFault(paper::kRa, 15.0, 3.0);
  drift.kind = FaultKind::kDrift;
  drift.until_s = 5.0;
  FaultStretch fault({drift}, 105, 0.002);
  HypothesisFit constant = StartAt(paper::kRa, 11.0);
  RefineComponent(fault.context, constant);
  const DriftFit moving = FitDrift(fault.context, constant);
  EXPECT_NEAR(moving.first_value, 7.41, 0.4);
  EXPECT_NEAR(moving.fit.value, 15.0, 0.5);
  EXPECT_LT(moving.fit.cost, constant.cost - 100.0);
}

TEST(Hypothesis, PredictionsOfR9AndR12CannotBeToldApart) {
  FaultStretch fault({AbruptFault(paper::kR9, 33e3, 1.0)}, 106);
  HypothesisFit r9 = StartAt(paper::kR9, 30e3);
  HypothesisFit r12 = StartAt(paper::kR12, 6e3);
  HypothesisFit ra = StartAt(paper::kRa, 7.0);
  RefineComponent(fault.context, r9);
  RefineComponent(fault.context, r12);
  RefineComponent(fault.context, ra);
  EXPECT_LT(PredictionDistance(fault.context, r9, r12), 2e-5);
  EXPECT_GT(PredictionDistance(fault.context, r9, ra), 1e-3);
  EXPECT_EQ(PredictionDistance(fault.context, r9, r9), 0.0);
}

TEST(Hypothesis, RatherBelievesInTenfoldThanInHundredfold) {
  const PlantParameters plant = paper::Plant();
  EXPECT_NEAR(MagnitudePrior(plant, paper::kJ, 10.0 * plant.j_kg_m2), 1.0, 1e-12);
  EXPECT_NEAR(MagnitudePrior(plant, paper::kJ, plant.j_kg_m2 / 100.0), 4.0, 1e-12);
  EXPECT_NEAR(MagnitudePrior(plant, paper::kC8, 1e-6), 0.0, 1e-12);
}

}  // namespace
}  // namespace faultlab::core
