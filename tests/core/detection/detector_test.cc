#include "core/detection/detector.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "core/calibration/calibrate.h"
#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

/// Time of the first alarm, of a rig that was learnt from another record.
std::optional<double> FirstAlarm(const std::vector<Sample>& record, const ModelError& error = {}) {
  const auto healthy = Between(BenchRecord({}, 62, 8.0), 0.5, 8.0);
  const Calibration calibration = Calibrate(healthy, paper::ToCalibrate()).value();
  Detector detector(paper::Bench(),
                    ParametersOf(calibration),
                    NoiseOf(calibration),
                    0.01,
                    7U,
                    calibration.thresholds,
                    calibration.samples,
                    NoiseScale(calibration.samples),
                    0.0,
                    false,
                    error);
  std::vector<double> t_s;
  const auto observations = MakeObservations(
      record, paper::Bench().readings(), Channels::kAll, 0.01, 10.0, {{}, error}, &t_s);
  for (std::size_t k = 0; k < observations.size(); ++k) {
    if (detector.Push(observations[k])) return t_s[k];
  }
  return std::nullopt;
}

TEST(Detector, KeepsQuietForAQuarterOfAnHourAndSeesAFaultAfterIt) {
  const auto record = BenchRecord({AbruptFault(paper::kRa, 6.0, 900.0)}, 61, 901.0);
  const std::optional<double> alarm_s = FirstAlarm(Between(record, 0.5, 901.0));
  ASSERT_TRUE(alarm_s.has_value());
  EXPECT_GE(*alarm_s, 900.0);
  EXPECT_LE(*alarm_s, 900.05);
}

// A network or a slow computer loses a sample now and then; what the others say adds up all the
// same.
TEST(Detector, SeesASmallFaultAlthoughSamplesAreLost) {
  const double small = 1.004 * paper::Plant().ra_ohm;
  auto record = BenchRecord({AbruptFault(paper::kRa, small, 300.0)}, 63, 320.0);
  const std::optional<double> whole_s = FirstAlarm(Between(record, 0.5, 320.0));
  ASSERT_TRUE(whole_s.has_value());
  EXPECT_GT(*whole_s, 301.0) << "else it is not small";
  std::erase_if(record, [](const Sample& sample) { return sample.index % 53 == 0; });
  const std::optional<double> lossy_s = FirstAlarm(Between(record, 0.5, 320.0));
  ASSERT_TRUE(lossy_s.has_value());
  EXPECT_GE(*lossy_s, 300.0) << "five minutes without a fault";
  EXPECT_LT(*lossy_s, *whole_s + 4.0);
}

TEST(Detector, RaThatWalksRaisesNoAlarmAndAFaultDoes) {
  const double walked = 1.03 * paper::Plant().ra_ohm;
  const double faulty = 2.0 * paper::Plant().ra_ohm;
  const auto record = BenchRecord(
      {AbruptFault(paper::kRa, walked, 5.0), AbruptFault(paper::kRa, faulty, 25.0)}, 64, 30.0);
  const std::optional<double> sure_s = FirstAlarm(Between(record, 0.5, 30.0));
  ASSERT_TRUE(sure_s.has_value());
  EXPECT_LT(*sure_s, 25.0);
  ModelError error;
  error.walk = {0.03, 0.0, 0.0};
  const std::optional<double> doubting_s = FirstAlarm(Between(record, 0.5, 30.0), error);
  ASSERT_TRUE(doubting_s.has_value());
  EXPECT_GE(*doubting_s, 25.0);
  EXPECT_LT(*doubting_s, 25.1);
}

TEST(Detector, WhatFollowsEveryStepOfTheInputCountsLess) {
  auto record = BenchRecord({AbruptFault(paper::kRa, 6.0, 25.0)}, 65, 30.0);
  for (std::size_t k = 1; k < record.size(); ++k) {
    if (record[k].uc_v != record[k - 1].uc_v) record[k].ia_a += 0.01;  // ten times its noise
  }
  const std::optional<double> alone_s = FirstAlarm(Between(record, 0.5, 30.0));
  ASSERT_TRUE(alone_s.has_value());
  EXPECT_LT(*alone_s, 25.0);
  ModelError error;
  error.step_v = 0.5;
  error.growth.fill({20.0, 20.0, 20.0, 10.0, 10.0, 10.0, 1.0});  // it misleads the state
  const std::optional<double> knowing_s = FirstAlarm(Between(record, 0.5, 30.0), error);
  ASSERT_TRUE(knowing_s.has_value());
  EXPECT_GE(*knowing_s, 25.0);
  EXPECT_LT(*knowing_s, 26.0) << "what follows the steps is all that counts less";
}

}  // namespace
}  // namespace faultlab::core
