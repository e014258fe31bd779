#include "server/lab/alarms.h"

#include <gmock/gmock.h>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

constexpr WallTime kAt{std::chrono::milliseconds{1'800'000'000'000}};

class AlarmsTest : public testing::TestWithParam<Engine> {
 protected:
  std::vector<Alarm> Listed(bool all = false) { return alarms_.List(all, 0, 100).value(); }

  tests::TestDatabase database_{GetParam()};
  Alarms alarms_{*database_};
};

TEST_P(AlarmsTest, OneAlarmOfACauseCountsHowOftenItWasTold) {
  ASSERT_TRUE(alarms_.Raise(AlarmKind::kInterlock, "bench-1", "stall", kAt).ok());
  ASSERT_TRUE(
      alarms_.Raise(AlarmKind::kInterlock, "bench-1", "over", kAt + std::chrono::seconds(5)).ok());
  ASSERT_TRUE(alarms_.Raise(AlarmKind::kInterlock, "bench-2", "stall", kAt).ok());
  const auto listed = Listed();
  ASSERT_THAT(listed, SizeIs(2));
  EXPECT_EQ(listed[1].subject, "bench-1");
  EXPECT_EQ(listed[1].times, 2);
  EXPECT_EQ(listed[1].text, "over");
  EXPECT_EQ(listed[1].at, kAt);
  EXPECT_EQ(listed[1].last, kAt + std::chrono::seconds(5));
}

TEST_P(AlarmsTest, OneThatLastsLeavesTheListWhenItIsOverAndSomebodyHasSeenIt) {
  ASSERT_TRUE(alarms_.Raise(AlarmKind::kCheckFailed, "bench-1", "b0d", kAt).ok());
  const std::int64_t id = Listed().at(0).id;
  const auto acked = alarms_.Acknowledge(id, 7, kAt);
  ASSERT_TRUE(acked.ok());
  EXPECT_EQ(acked.value().alarm.acked_by, 7);
  EXPECT_FALSE(acked.value().alarm.ended.has_value()) << "the rig is still out";
  const auto again = alarms_.Acknowledge(id, 8, kAt).value();
  EXPECT_EQ(again.alarm.acked_by, 7) << "the first one stays";
  EXPECT_FALSE(again.first) << "and is the only line of the audit log";
  EXPECT_THAT(Listed(), SizeIs(1));
  ASSERT_TRUE(alarms_.End(AlarmKind::kCheckFailed, "bench-1", kAt).ok());
  EXPECT_THAT(Listed(), IsEmpty());
  EXPECT_THAT(Listed(true), SizeIs(1));
  // The same cause again is a new alarm that nobody has seen.
  ASSERT_TRUE(alarms_.Raise(AlarmKind::kCheckFailed, "bench-1", "b0d", kAt).ok());
  EXPECT_FALSE(Listed().at(0).acked.has_value());
  ASSERT_TRUE(alarms_.End(AlarmKind::kCheckFailed, "bench-1", kAt).ok());
  EXPECT_THAT(Listed(), SizeIs(1)) << "over, but nobody has seen it";
}

TEST_P(AlarmsTest, OneThatHappensOnceIsOverWhenItIsSeen) {
  ASSERT_TRUE(alarms_.Raise(AlarmKind::kDeltaStrays, "bench-1", "9.9 ms", kAt).ok());
  EXPECT_TRUE(alarms_.Acknowledge(Listed().at(0).id, 7, kAt).value().alarm.ended.has_value());
  EXPECT_THAT(Listed(), IsEmpty());
  EXPECT_EQ(alarms_.Acknowledge(999, 7, kAt).error().code, core::ErrorCode::kNotFound);
}

TEST_P(AlarmsTest, OldOnesThatHaveEndedAreDeletedOpenOnesNever) {
  ASSERT_TRUE(alarms_.Raise(AlarmKind::kSilent, "bench-9", "away", kAt).ok());
  for (int i = 0; i < Alarms::kKept + 20; ++i) {
    ASSERT_TRUE(alarms_.Raise(AlarmKind::kInterlock, "bench-1", "stall", kAt).ok());
    ASSERT_TRUE(alarms_.End(AlarmKind::kInterlock, "bench-1", kAt).ok());
  }
  const auto all = alarms_.List(true, 0, 10'000).value();
  EXPECT_LE(std::ssize(all), Alarms::kKept + 2);
  EXPECT_EQ(all.back().subject, "bench-9");
}

INSTANTIATE_TEST_SUITE_P(Engines, AlarmsTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::lab
