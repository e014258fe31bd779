#include "core/diagnosis/alarm_record.h"

#include <gtest/gtest.h>

#include <vector>

namespace faultlab::core {
namespace {

Sample At(int index) {
  Sample sample;
  sample.index = index;
  sample.t_s = 0.01 * index;
  return sample;
}

AlarmRecord AlarmAfter(int healthy, int samples_ago, bool sharp) {
  AlarmRecord record;
  for (int k = 0; k < healthy; ++k) record.Remember(At(k));
  Alarm alarm;
  alarm.samples_ago = samples_ago;
  alarm.sharp = sharp;
  record.Open(alarm, false);
  return record;
}

TEST(AlarmRecord, KeepsSixSecondsOfHistoryAndTheDetectorsOnset) {
  AlarmRecord record = AlarmAfter(5000, 7, false);
  IsolationTask task;
  record.Fill(task);
  EXPECT_EQ(task.samples.size(), 600U);
  EXPECT_EQ(task.samples.back().index, 4999);
  EXPECT_EQ(task.alarm_at, 599U);
  EXPECT_EQ(task.fit_from, 592U);
  EXPECT_DOUBLE_EQ(record.onset_t_s(), 49.92);
  EXPECT_FALSE(task.onset.has_value()) << "it can be looked for";
  EXPECT_FALSE(task.settled);
}

TEST(AlarmRecord, FitsASharpAlarmFromItsOwnSample) {
  AlarmRecord record = AlarmAfter(100, 7, true);
  IsolationTask task;
  record.Fill(task);
  EXPECT_EQ(task.fit_from, 99U);
  EXPECT_EQ(task.alarm_at, 99U);
}

TEST(AlarmRecord, FitsFromTheAlarmWhereTheOnsetWasNotIt) {
  AlarmRecord record = AlarmAfter(100, 7, false);
  record.FitFromAlarm();
  IsolationTask task;
  record.Fill(task);
  EXPECT_EQ(task.fit_from, 99U);
  EXPECT_DOUBLE_EQ(record.onset_t_s(), 0.92) << "which stays the detector's estimate";
}

// When fits are due; `untold`: after each the answer is that nothing can be told yet.
std::vector<int> DueFits(bool untold) {
  AlarmRecord record = AlarmAfter(700, 0, true);
  std::vector<int> due;
  for (int k = 1; k <= 2100; ++k) {
    record.Append(At(699 + k));
    if (!record.FitIsDue()) continue;
    due.push_back(k);
    record.ScheduleNextFit();
    if (untold && k >= 100) record.FitSoon();
  }
  return due;
}

TEST(AlarmRecord, IsDueForFitsEverLessOften) {
  EXPECT_EQ(DueFits(false), (std::vector<int>{4, 8, 16, 25, 50, 100, 200, 500, 1000, 1500, 2000}));
}

TEST(AlarmRecord, WaitsForMoreSamplesOfASmallChange) {
  AlarmRecord record;
  for (int k = 0; k < 700; ++k) record.Remember(At(k));
  Alarm alarm;
  alarm.detector = "glr_500";
  record.Open(alarm, false);
  for (int k = 1; k <= 24; ++k) {
    record.Append(At(699 + k));
    EXPECT_FALSE(record.FitIsDue()) << k;
  }
  record.Append(At(724));
  EXPECT_TRUE(record.FitIsDue());
}

TEST(AlarmRecord, IsDueEverySecondOfTenWhileNothingCanBeTold) {
  EXPECT_EQ(DueFits(true),
            (std::vector<int>{
                4, 8, 16, 25, 50, 100, 200, 300, 400, 500, 600, 700, 800, 900, 1000, 1500, 2000}));
}

TEST(AlarmRecord, RemembersTheOnsetThatHasLeftTheSamples) {
  AlarmRecord record = AlarmAfter(700, 3, false);
  record.SetOnset({6.97, false});
  for (int k = 1; k <= 4000; ++k) record.Append(At(699 + k));
  IsolationTask task;
  record.Fill(task);
  EXPECT_EQ(task.samples.size(), 2000U);
  EXPECT_EQ(task.samples.back().index, 4699);
  EXPECT_EQ(task.alarm_at, 0U);
  EXPECT_EQ(task.fit_from, 0U);
  ASSERT_TRUE(task.onset.has_value());
  EXPECT_EQ(task.onset->t_s, 6.97);
  EXPECT_TRUE(task.settled);
}

TEST(AlarmRecord, TakesItsNewestSamplesForHistoryWhenTheAlarmIsOver) {
  AlarmRecord record = AlarmAfter(700, 3, false);
  for (int k = 1; k <= 50; ++k) record.Append(At(699 + k));
  record.Close();
  record.Remember(At(750));
  record.Open({}, false);
  IsolationTask task;
  record.Fill(task);
  EXPECT_EQ(task.samples.size(), 600U);
  EXPECT_EQ(task.samples.front().index, 151);
  EXPECT_EQ(task.samples.back().index, 750);
}

}  // namespace
}  // namespace faultlab::core
