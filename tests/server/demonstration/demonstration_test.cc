// The recordings and studies that the page's Learn shows.
#include "server/demonstration/demonstration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "hardware/bench/benches.h"
#include "server/demonstration/detection_study.h"
#include "server/demonstration/estimate_study.h"

namespace faultlab::server {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const core::Bench& Paper() {
  return *hardware::LoadBench("paper").value();
}
std::vector<core::Fault> Changes(const std::string& text) {
  return ParseChanges(text, Paper()).value();
}
EstimateStudy Swa(int window, double noise_percent = 2.0) {
  EstimateQuestion question;
  question.window_samples = window;
  question.added_noise_percent = noise_percent;
  question.changes = Changes("R1:10");
  return StudyEstimates(Paper(), question).value();
}
EstimateStudy Sia(int window, int integral, core::SiaMode mode, double noise_percent = 0.0) {
  EstimateQuestion question;
  question.method = core::EstimatorMethod::kSia;
  question.window_samples = window;
  question.integral_samples = integral;
  question.sia_mode = mode;
  question.added_noise_percent = noise_percent;
  return StudyEstimates(Paper(), question).value();
}

TEST(Changes, AreReadAndNamedWhenRefused) {
  EXPECT_THAT(Changes(""), IsEmpty());
  EXPECT_THAT(Changes("R9:33000,R12:5600"), SizeIs(2));
  for (const char* wrong :
       {"R1", "R1:", "R1:-3", "R1:nan", ",", "R1:10,R1:20", "X:1", "R1:1e30", "R1:1x"}) {
    const auto parsed = ParseChanges(wrong, Paper());
    ASSERT_FALSE(parsed.ok()) << wrong;
    EXPECT_EQ(parsed.error().field, "changes");
  }
}

TEST(Demonstration, DiffersByItsChangesAlone) {
  const Demonstration healthy = PlayDemonstration(Paper(), {}, {}).value();
  const Demonstration faulty = PlayDemonstration(Paper(), Changes("R1:100"), {}).value();
  ASSERT_THAT(healthy.samples, SizeIs(2000));
  for (std::size_t i = 0; i < healthy.fault_at; ++i) {
    ASSERT_EQ(healthy.samples[i].um_v, faulty.samples[i].um_v) << i;
  }
  EXPECT_NE(healthy.samples[1010].um_v, faulty.samples[1010].um_v);
}

TEST(Demonstration, OfTwoPartsThatSetOneGainLooksHealthyWhenTheyCancel) {
  // 1/Re1 = 1/R9 + 1/R10 and Re2 = R12 + 2 kohm: these have the nominal gain of 12/5
  const double r12 = 2.4 / (1.0 / 33e3 + 1.0 / 10e3) - 2e3;
  const auto both = Changes("R9:33000,R12:" + std::to_string(r12));
  const Demonstration healthy = PlayDemonstration(Paper(), {}, {}).value();
  const Demonstration cancelled = PlayDemonstration(Paper(), both, {}).value();
  const Demonstration one = PlayDemonstration(Paper(), Changes("R9:33000"), {}).value();
  double cancelled_v = 0.0;
  double one_v = 0.0;
  for (std::size_t i = 1050; i < 2000; ++i) {
    const double um_v = healthy.samples[i].um_v;
    cancelled_v = std::max(cancelled_v, std::abs(cancelled.samples[i].um_v - um_v));
    one_v = std::max(one_v, std::abs(one.samples[i].um_v - um_v));
  }
  EXPECT_LT(cancelled_v, 2e-3);  // two steps of the converter behind its divider
  EXPECT_GT(one_v, 1.0);
}

TEST(EstimateStudy, ALargerWindowHasLessVarianceAndMoreDelay) {
  double deviation = 1e9;
  double delay_s = 0.0;
  for (const int window : {20, 50, 100, 200, 500}) {
    const EstimateStudy study = Swa(window);
    const EstimateStudy::Parameter& b0d = study.parameters[0];
    EXPECT_LT(b0d.deviation, deviation) << window;
    deviation = b0d.deviation;
    ASSERT_TRUE(b0d.delay_s.has_value()) << window;
    EXPECT_GT(*b0d.delay_s, delay_s) << window;
    EXPECT_LE(*b0d.delay_s, study.settle_s + 0.01) << window;
    delay_s = *b0d.delay_s;
    EXPECT_NEAR(study.settle_s, 0.01 * (window - 1), 1e-9);
    ASSERT_THAT(b0d.estimates, SizeIs(2000));
    EXPECT_NEAR(b0d.mean_after, b0d.changed, 0.05 * std::abs(b0d.changed)) << window;
  }
}

TEST(EstimateStudy, NoiseRaisesTheVarianceAndBiasesSwa) {
  const EstimateStudy quiet = Swa(100, 0.0);
  const EstimateStudy noisy = Swa(100, 20.0);
  EXPECT_EQ(quiet.added_noise, 0.0);
  EXPECT_GT(noisy.added_noise, 0.0);
  EXPECT_GT(noisy.parameters[0].deviation, 2.0 * quiet.parameters[0].deviation);
  // a1d is drawn towards 0
  EXPECT_GT(noisy.parameters[2].mean, quiet.parameters[2].mean + 0.01);
}

TEST(EstimateStudy, TheExactRuleUndoesThatOfThePaper) {
  const EstimateStudy paper = Sia(100, 20, core::SiaMode::kPaper);
  const EstimateStudy exact = Sia(100, 20, core::SiaMode::kExact);
  const double a1_s = exact.parameters[2].mean;
  EXPECT_NEAR(paper.parameters[2].mean, 0.01 / (1.0 - std::exp(-0.01 / a1_s)), 0.01 * a1_s);
}

TEST(EstimateStudy, RefusesByTheNameOfTheParameter) {
  EstimateQuestion question;
  question.window_samples = 5;
  EXPECT_EQ(StudyEstimates(Paper(), question).error().field, "window");
  question.method = core::EstimatorMethod::kSia;
  question.window_samples = 100;
  question.integral_samples = 100;
  EXPECT_EQ(StudyEstimates(Paper(), question).error().field, "integral");
}

TEST(DetectionStudy, AHigherRateOfFalseAlarmsDetectsSooner) {
  DetectionStudies studies;
  const auto changes = Changes("J:1.7e-6");
  const DetectionStudy strict = studies.Study(Paper(), changes, 1.0).value();
  const DetectionStudy loose = studies.Study(Paper(), changes, 10'000.0).value();
  EXPECT_THAT(strict.false_alarms_s, IsEmpty());
  EXPECT_GE(loose.false_alarms_s.size(), 1U);
  EXPECT_LE(loose.false_alarms_s.size(), 40U);  // seven are expected
  ASSERT_TRUE(strict.delay_s && loose.delay_s);
  EXPECT_LE(*loose.delay_s, *strict.delay_s);
  EXPECT_THAT(strict.level, SizeIs(650));
  EXPECT_LT(*std::max_element(strict.level.begin(), strict.level.begin() + 600), 1.0);
  EXPECT_FALSE(strict.detector.empty());
}

TEST(DetectionStudy, EveryShippedBenchHasOne) {
  DetectionStudies studies;
  for (const char* name : {"paper", "servo-motor", "gear-motor"}) {
    const core::Bench& bench = *hardware::LoadBench(name).value();
    const auto study = studies.Study(bench, {}, 1.0);
    ASSERT_TRUE(study.ok()) << name << ": " << study.error().message;
    EXPECT_FALSE(study.value().delay_s.has_value()) << name;
    EstimateQuestion question;
    EXPECT_TRUE(StudyEstimates(bench, question).ok()) << name;
  }
}

}  // namespace
}  // namespace faultlab::server
