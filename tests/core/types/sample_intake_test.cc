#include "core/types/sample_intake.h"

#include <gtest/gtest.h>

#include <limits>

namespace faultlab::core {
namespace {

Sample At(std::int64_t index, double t_s, double um_v = 5.0) {
  Sample sample;
  sample.index = index;
  sample.t_s = t_s;
  sample.uc_v = 2.0;
  sample.um_v = um_v;
  return sample;
}

TEST(SampleIntake, UsesConsecutiveSamplesWithJitter) {
  SampleIntake intake(0.01);
  EXPECT_EQ(intake.Classify(At(7, 0.07)).use, SampleUse::kUse);
  const SampleStep step = intake.Classify(At(8, 0.0838));
  EXPECT_EQ(step.use, SampleUse::kUse);
  EXPECT_EQ(step.missing, 0);
}

TEST(SampleIntake, IgnoresRepeatedAndLateSamples) {
  SampleIntake intake(0.01);
  intake.Classify(At(7, 0.07));
  EXPECT_EQ(intake.Classify(At(7, 0.07)).use, SampleUse::kIgnore);
  EXPECT_EQ(intake.Classify(At(6, 0.06)).use, SampleUse::kIgnore);
  EXPECT_EQ(intake.Classify(At(8, 0.0701)).use, SampleUse::kIgnore);
  const SampleStep next = intake.Classify(At(8, 0.08));
  EXPECT_EQ(next.use, SampleUse::kUse);
  EXPECT_EQ(next.missing, 0);
}

TEST(SampleIntake, CountsMissingSamplesByIndexOrByTime) {
  SampleIntake intake(0.01);
  intake.Classify(At(0, 0.0));
  EXPECT_EQ(intake.Classify(At(5, 0.05)).missing, 4);
  EXPECT_EQ(intake.Classify(At(6, 0.09)).missing, 3);
  EXPECT_EQ(intake.Classify(At(7, std::numeric_limits<double>::quiet_NaN())).missing, 0);
  EXPECT_EQ(intake.Classify(At(8, 1e300)).missing, 0) << "the time before it was not known";
  EXPECT_EQ(intake.Classify(At(1'000'000'000'000, 2e300)).missing, 999'999'999);
}

TEST(SampleIntake, SetsClippedReadingsAsideButLetsNonFiniteOnesThrough) {
  SampleIntake intake(0.01);
  EXPECT_EQ(intake.Classify(At(0, 0.0, 9.9997)).use, SampleUse::kClipped);
  EXPECT_EQ(intake.Classify(At(1, 0.01, -10.0)).use, SampleUse::kClipped);
  EXPECT_EQ(intake.Classify(At(2, 0.02, std::numeric_limits<double>::quiet_NaN())).use,
            SampleUse::kUse);
  EXPECT_EQ(intake.Classify(At(3, 0.03, std::numeric_limits<double>::infinity())).use,
            SampleUse::kUse);
}

}  // namespace
}  // namespace faultlab::core
