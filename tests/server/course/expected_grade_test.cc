#include "server/course/expected_grade.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <numeric>

#include "tests/paper_bench.h"

namespace faultlab::server::course {
namespace {

constexpr double kSeparable = 10.0;

FaultPool ReadPool(const char* text) {
  return ParsePool(boost::json::parse(text).as_object(), paper::Bench()).value();
}

/// @param rival  distance of the nearest other component
core::FaultIsolability Judged(double kl_nominal, double rival) {
  core::FaultIsolability out;
  out.kl_nominal_nats = kl_nominal;
  out.rival = {{paper::kRa, 0.0, 6.0}, {paper::kR1, rival, 6.0}};
  return out;
}

LikelyDraw FaultOfShare(double share) {
  return {core::FaultSize{paper::kRa, 6.0}, share};
}

TEST(LikelyDraws, SumToOneAndStandForRangesAndLists) {
  const FaultPool pool = ReadPool(R"({"healthy_share":0.25,"items":[
      {"component":"R1","low":1,"high":1000,"onset_from_s":8},
      {"component":"Ra","values":[6,9],"onset_from_s":8,"weight":2},
      {"component":"J","values":[5e-6,1e-6,4e-6],"onset_from_s":8}]})");
  const std::vector<LikelyDraw> draws = LikelyDraws(pool);
  ASSERT_EQ(draws.size(), 9U);
  EXPECT_FALSE(draws[0].fault);
  EXPECT_NEAR(draws[1].fault->value, 3.162, 1e-9);
  EXPECT_NEAR(draws[3].fault->value, 316.2, 1e-9);
  EXPECT_DOUBLE_EQ(draws[4].share, 0.75 / 4.0) << "twice the weight, two values";
  EXPECT_DOUBLE_EQ(draws[6].fault->value, 5e-6);
  EXPECT_DOUBLE_EQ(draws[7].fault->value, 1e-6);
  EXPECT_DOUBLE_EQ(draws[8].fault->value, 4e-6);
  const double sum = std::accumulate(
      draws.begin(), draws.end(), 0.0, [](double s, const LikelyDraw& d) { return s + d.share; });
  EXPECT_DOUBLE_EQ(sum, 1.0);
}

TEST(ExpectedGrade, IsFullWhereAllIsPlain) {
  const std::vector<LikelyDraw> draws = {{std::nullopt, 0.2}, FaultOfShare(0.8)};
  const std::vector<core::FaultIsolability> judged = {Judged(500.0, 400.0)};
  const ExpectedGrade expected = ExpectGrade({}, draws, judged, kSeparable);
  EXPECT_NEAR(expected.points, 100.0, 1e-9);
  EXPECT_NEAR(expected.spread, 0.0, 1e-4);
}

TEST(ExpectedGrade, WhatCannotBeSeenIsACoinAndSoIsItsHealthyRig) {
  const std::vector<LikelyDraw> draws = {{std::nullopt, 0.5}, FaultOfShare(0.5)};
  const std::vector<core::FaultIsolability> judged = {Judged(0.0, 0.0)};
  const ExpectedGrade expected = ExpectGrade({}, draws, judged, kSeparable);
  // Half of 20 + 40 + 30, and of the 10 for the confidence three quarters.
  EXPECT_NEAR(expected.points, 52.5, 1e-9);
  EXPECT_NEAR(expected.spread, 0.0, 1e-4);
}

TEST(ExpectedGrade, AnotherComponentCostsOnlyWhatTheGradeDoesNotTakeForIt) {
  const std::vector<LikelyDraw> draws = {FaultOfShare(1.0)};
  const auto points = [&](double rival) {
    const std::vector<core::FaultIsolability> judged = {Judged(500.0, rival)};
    return ExpectGrade({}, draws, judged, kSeparable).points;
  };
  EXPECT_NEAR(points(0.0), 100.0, 1e-9) << "alike: both count";
  EXPECT_NEAR(points(kSeparable), 100.0 - 70.0 * 0.01267 - 0.125, 0.01) << "Phi(-sqrt(20) / 2)";
}

TEST(ExpectedGrade, TheSpreadIsThatBetweenDraws) {
  const std::vector<LikelyDraw> draws = {FaultOfShare(0.5), FaultOfShare(0.5)};
  const std::vector<core::FaultIsolability> judged = {Judged(500.0, 400.0), Judged(0.0, 0.0)};
  const ExpectedGrade expected = ExpectGrade({}, draws, judged, kSeparable);
  EXPECT_NEAR(expected.points, 76.25, 1e-9);
  EXPECT_NEAR(expected.spread, 23.75, 1e-6);
  EXPECT_NEAR(expected.hardest_points, 52.5, 1e-9);
}

}  // namespace
}  // namespace faultlab::server::course
