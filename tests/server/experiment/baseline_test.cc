#include "server/experiment/baseline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "core/signals/excitation.h"
#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

using std::chrono::minutes;
using testing::HasSubstr;
using testing::IsEmpty;

const WallTime kLearnt{std::chrono::milliseconds{1'770'000'000'000}};

core::Calibration Healthy() {
  const core::Bench& bench = paper::Bench();
  core::Calibration calibration;
  calibration.from_s = 0.5;
  calibration.to_s = 5.0;
  calibration.nominal = bench.nominal;
  calibration.mc_nm = bench.norm.mc_nm;
  calibration.mc_sigma_nm = bench.norm.mc_sigma_nm;
  return calibration;
}

core::CalibratedQuantity Quantity(double value, bool from_data = true) {
  core::CalibratedQuantity j;
  j.name = "J";
  j.value = value;
  j.prior_value = 1.43e-6;
  j.prior_sigma = 0.05 * 1.43e-6;
  j.from_data = from_data;
  return j;
}

InputRange Usual() {
  return UsualRange(paper::Bench(), 4.5);
}

TEST(Baseline, RangeOfAnInputIsItsEndsAndItsMovement) {
  const std::vector<double> uc_v = {2.0, 3.0, 3.0, 2.0};
  const InputRange range = RangeOf(uc_v);
  EXPECT_EQ(range.low_v, 2.0);
  EXPECT_EQ(range.high_v, 3.0);
  EXPECT_DOUBLE_EQ(range.rms_v, 0.5);
  EXPECT_EQ(RangeOf({}).rms_v, 0.0);
}

TEST(Baseline, IsWhatAPersonHasLearntWithTheUsualExcitation) {
  core::Calibration calibration = Healthy();
  calibration.quantities = {Quantity(1.5e-6)};
  EXPECT_THAT(WhyNoBaseline("user:1", Usual(), calibration, paper::Bench()), IsEmpty());
}

TEST(Baseline, IsNeverAGuests) {
  EXPECT_THAT(WhyNoBaseline("guest", Usual(), Healthy(), paper::Bench()), HasSubstr("guest"));
  EXPECT_THAT(WhyNoBaseline("", Usual(), Healthy(), paper::Bench()), HasSubstr("guest"));
}

TEST(Baseline, IsNotLearntFromAnInputThatHardlyMoves) {
  InputRange input = Usual();
  input.rms_v *= 0.4;  // the PRBS of 0 V to 0.4 V that spoilt a rig for the next hour
  EXPECT_THAT(WhyNoBaseline("user:1", input, Healthy(), paper::Bench()), HasSubstr("movement"));
}

TEST(Baseline, LiesWithinTheNormOfTheRig) {
  core::Calibration calibration = Healthy();
  calibration.quantities = {Quantity(2.0e-6)};
  EXPECT_THAT(WhyNoBaseline("user:1", Usual(), calibration, paper::Bench()), HasSubstr("J"));
  calibration.quantities = {Quantity(2.0e-6, /*from_data=*/false)};
  EXPECT_THAT(WhyNoBaseline("user:1", Usual(), calibration, paper::Bench()), IsEmpty());
}

TEST(Baseline, CoversOnlyRunsWithinItsInput) {
  const InputRange learnt{2.0, 3.0, 0.5};
  EXPECT_TRUE(Covers(learnt, {2.0, 3.0, 0.5}));
  EXPECT_TRUE(Covers(learnt, {2.2, 2.8, 0.3}));
  EXPECT_FALSE(Covers(learnt, {1.0, 3.0, 0.5}));
  EXPECT_FALSE(Covers(learnt, {2.0, 4.0, 0.5}));
  EXPECT_FALSE(Covers({0.0, 0.4, 0.2}, learnt)) << "another operating point";
  EXPECT_FALSE(Covers({}, learnt)) << "of an earlier program";
}

class ConfirmedBaseline : public testing::Test {
 protected:
  lab::CheckRecord Check(WallTime at, double factor = 1.0) const {
    const lab::RigBand& found = norm_.centre;
    const auto step = [](const char* name, double measured) {
      lab::CheckStep one{.step = name, .passed = true};
      one.figure = lab::CheckStep::Figure{measured, 0.0, 0.0, ""};
      return one;
    };
    lab::CheckRecord check;
    check.at = at;
    check.kind = "between_users";
    check.passed = true;
    check.steps = {
        step("b0d", factor * found.b0d), step("gain", factor * found.gain), step("a1d", found.a1d)};
    return check;
  }
  bool Confirmed(const std::vector<lab::CheckRecord>& checks,
                 const core::Calibration& calibration = Healthy()) const {
    return IsConfirmed(checks, kLearnt, calibration, paper::Bench(), paper::Bench().delta_s);
  }

  const lab::RigNorm norm_ = lab::NominalNorm(paper::Bench(), paper::Bench().delta_s).value();
};

TEST_F(ConfirmedBaseline, IsOneThatALaterCheckFindsAgain) {
  EXPECT_TRUE(Confirmed({Check(kLearnt + minutes(5))}));
  EXPECT_FALSE(Confirmed({Check(kLearnt - minutes(5))})) << "before it was learnt";
  EXPECT_FALSE(Confirmed({})) << "nothing was checked";
}

TEST_F(ConfirmedBaseline, IsDroppedByACheckThatFindsAnotherRig) {
  EXPECT_FALSE(Confirmed({Check(kLearnt + minutes(5), 1.4)}));
  core::Calibration other = Healthy();
  other.gain_factor = 1.4;
  EXPECT_FALSE(Confirmed({Check(kLearnt + minutes(5))}, other));
}

TEST_F(ConfirmedBaseline, FollowsTheNewestCheckBetweenUsers) {
  lab::CheckRecord failed = Check(kLearnt + minutes(9));
  failed.passed = false;
  EXPECT_FALSE(Confirmed({failed, Check(kLearnt + minutes(5))}));
  lab::CheckRecord self_test = Check(kLearnt + minutes(9), 1.4);
  self_test.kind = "self_test";
  EXPECT_TRUE(Confirmed({self_test, Check(kLearnt + minutes(5))}));
}

}  // namespace
}  // namespace faultlab::server
