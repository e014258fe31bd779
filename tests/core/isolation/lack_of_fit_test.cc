#include "core/isolation/lack_of_fit.h"

#include <gtest/gtest.h>

#include "core/isolation/component_scan.h"
#include "tests/core/isolation/fault_stretch.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

HypothesisFit BestOf(const FaultStretch& fault, Component component) {
  HypothesisFit fit = ScanComponents(fault.context, std::span(&component, 1)).front();
  RefineComponent(fault.context, fit);
  return fit;
}

TEST(LackOfFit, IsNotFoundInTheRightHypothesis) {
  FaultStretch fault({AbruptFault(paper::kRa, 12.0, 1.0)}, 111, 0.002);
  const LackOfFit judged = TestLackOfFit(fault.context, BestOf(fault, paper::kRa));
  EXPECT_TRUE(judged.adequate) << judged.score << " " << judged.moved;
  EXPECT_TRUE(judged.relaxed);
  EXPECT_LT(judged.relaxed_gain, 45.0);
}

TEST(LackOfFit, IsFoundByTheScoreInTheWrongComponent) {
  FaultStretch fault({AbruptFault(paper::kRa, 12.0, 1.0)}, 112, 0.002);
  const LackOfFit judged = TestLackOfFit(fault.context, BestOf(fault, paper::kC8));
  EXPECT_FALSE(judged.adequate);
  EXPECT_GT(judged.score, 2.0);
  EXPECT_FALSE(judged.relaxed) << "the score alone decides";
}

TEST(LackOfFit, NamesTheSecondComponentThatRelaxingMoves) {
  FaultStretch fault(
      {AbruptFault(paper::kR9, 33e3, 1.0), AbruptFault(paper::kRa, 8.2, 1.0)}, 113, 0.002);
  const HypothesisFit fit = BestOf(fault, paper::kR9);
  LackOfFit judged = TestScore(fit);
  TestRelaxed(fault.context, fit, judged);
  EXPECT_FALSE(judged.adequate);
  EXPECT_NE(judged.moved.find("Ra"), std::string::npos) << judged.moved;
  EXPECT_NE(judged.beside.find("Ra"), std::string::npos) << judged.beside;
  EXPECT_EQ(judged.beside.find("the gain"), std::string::npos)
      << "R9 is the gain: " << judged.beside;
}

TEST(LackOfFit, IsNotJudgedByRelaxingFewReadings) {
  FaultStretch fault({AbruptFault(paper::kRa, 12.0, 1.0)}, 114, 0.002);
  fault.context.stretch = fault.context.stretch.first(19);  // 57 readings
  const HypothesisFit fit = FitNullHypothesis(fault.context);
  LackOfFit judged;
  TestRelaxed(fault.context, fit, judged);
  EXPECT_TRUE(judged.relaxed);
  EXPECT_TRUE(judged.adequate);
  EXPECT_EQ(judged.relaxed_gain, 0.0);
}

}  // namespace
}  // namespace faultlab::core
