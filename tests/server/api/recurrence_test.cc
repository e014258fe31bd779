#include "server/api/sharing/recurrence.h"

#include <gmock/gmock.h>

#include "server/api/iso8601.h"

namespace faultlab::server {
namespace {

using testing::ElementsAre;

Recurrence Mondays(const std::string& repeat) {
  return {.start = "2027-03-15T10:00:00+01:00",
          .end = "2027-03-15T12:00:00+01:00",
          .repeat = repeat,
          .time_zone = "Europe/Belgrade",
          .except = {}};
}

std::vector<std::string> Starts(const Recurrence& wanted) {
  const auto times = TimesOf(wanted);
  if (!times) return {times.error().reason};
  std::vector<std::string> starts;
  for (const lab::Interval& time : times.value()) starts.push_back(Iso8601(time.start));
  return starts;
}

TEST(Recurrence, KeepsItsHourOverAClockChange) {
  EXPECT_THAT(
      Starts(Mondays("FREQ=WEEKLY;COUNT=3")),
      ElementsAre(
          "2027-03-15T09:00:00.000Z", "2027-03-22T09:00:00.000Z", "2027-03-29T08:00:00.000Z"));
  const auto times = TimesOf(Mondays("FREQ=WEEKLY;COUNT=3"));
  ASSERT_TRUE(times.ok());
  EXPECT_EQ(times.value().back().length(), std::chrono::hours(2));
}

TEST(Recurrence, UntilIsAnInstantAHourThereOrAWholeDate) {
  for (const char* until : {"20270322T090000Z", "20270322T100000", "20270322"}) {
    EXPECT_EQ(Starts(Mondays("FREQ=WEEKLY;UNTIL=" + std::string(until))).size(), 2u) << until;
  }
  EXPECT_EQ(Starts(Mondays("FREQ=WEEKLY;UNTIL=20270322T085959Z")).size(), 1u);
}

TEST(Recurrence, KnowsWhatICalendarKnows) {
  EXPECT_THAT(Starts(Mondays("FREQ=MONTHLY;BYDAY=3MO;COUNT=2")),
              ElementsAre("2027-03-15T09:00:00.000Z", "2027-04-19T08:00:00.000Z"));
  EXPECT_EQ(Starts(Mondays("FREQ=DAILY;BYDAY=MO,TU,WE,TH,FR;UNTIL=20270409")).size(), 20u);
  EXPECT_EQ(Starts(Mondays("FREQ=WEEKLY;INTERVAL=2;BYDAY=MO,WE;COUNT=4")).size(), 4u);
}

TEST(Recurrence, LeavesOutDatesOfTheZone) {
  Recurrence wanted = Mondays("FREQ=WEEKLY;COUNT=3");
  wanted.except = {"2027-03-22"};
  EXPECT_THAT(Starts(wanted), ElementsAre("2027-03-15T09:00:00.000Z", "2027-03-29T08:00:00.000Z"));
  wanted.except = {"2027-03-15", "2027-03-22", "2027-03-29"};
  EXPECT_THAT(Starts(wanted), ElementsAre("repeat_leaves_none"));
}

TEST(Recurrence, RefusesWhatHasNoEndOrNoSense) {
  EXPECT_THAT(Starts(Mondays("FREQ=WEEKLY")), ElementsAre("repeat_endless"));
  EXPECT_THAT(Starts(Mondays("FREQ=HOURLY;COUNT=3")), ElementsAre("repeat_often"));
  EXPECT_THAT(Starts(Mondays("FREQ=SECONDLY;BYMONTH=2;BYMONTHDAY=30;COUNT=3")),
              ElementsAre("repeat_often"));
  EXPECT_THAT(Starts(Mondays("FREQ=DAILY;BYMONTH=2;BYMONTHDAY=30;COUNT=3")),
              ElementsAre("repeat_misses_start"));
  EXPECT_THAT(Starts(Mondays("every Monday")), ElementsAre("repeat_unreadable"));
  EXPECT_THAT(Starts(Mondays("FREQ=WEEKLY;COUNT=-3")),
              testing::AnyOf(ElementsAre("repeat_endless"), ElementsAre("repeat_unreadable")));
  EXPECT_THAT(Starts(Mondays("FREQ=WEEKLY;BYDAY=TU;COUNT=3")), ElementsAre("repeat_misses_start"));
  EXPECT_THAT(Starts(Mondays("FREQ=YEARLY;BYMONTH=2;BYMONTHDAY=30;COUNT=3")),
              testing::AnyOf(ElementsAre("repeat_unreadable"), ElementsAre("repeat_misses_start")));
  EXPECT_THAT(Starts(Mondays("FREQ=DAILY;COUNT=100000")), ElementsAre("repeat_too_long"));
  EXPECT_THAT(Starts(Mondays("FREQ=MONTHLY;BYDAY=3MO;COUNT=50")), ElementsAre("repeat_too_long"));
  // Each of these would keep a thread busy for hours.
  std::string list = "0";
  for (int i = 1; i < 60; ++i) list += "," + std::to_string(i);
  for (const std::string& by :
       {"BYMINUTE=" + list + ";BYSECOND=" + list, std::string("BYHOUR=1")}) {
    EXPECT_THAT(Starts(Mondays("FREQ=DAILY;COUNT=1;BYMONTH=2;BYMONTHDAY=30;" + by)),
                ElementsAre("repeat_unreadable"));
  }
  EXPECT_THAT(Starts(Mondays("FREQ=YEARLY;COUNT=5")), ElementsAre("repeat_unreadable"));
  EXPECT_THAT(Starts(Mondays("FREQ=WEEKLY;BYDAY=MO,WE;BYSETPOS=1;COUNT=5")),
              ElementsAre("repeat_unreadable"));
  EXPECT_THAT(Starts(Mondays("RSCALE=HEBREW;FREQ=MONTHLY;COUNT=5")),
              ElementsAre("repeat_unreadable"));
  Recurrence wanted = Mondays("FREQ=DAILY;COUNT=3");
  wanted.end = "2027-03-17T10:00:00+01:00";
  EXPECT_THAT(Starts(wanted), ElementsAre("repeat_overlaps"));
  wanted.end = wanted.start;
  EXPECT_THAT(Starts(wanted), ElementsAre("end_before_start"));
  wanted = Mondays("FREQ=WEEKLY;COUNT=3");
  wanted.time_zone = "Mars/Olympus";
  EXPECT_THAT(Starts(wanted), ElementsAre("time_zone_unknown"));
  wanted.time_zone = "../../etc/passwd";
  EXPECT_THAT(Starts(wanted), ElementsAre("time_zone_unknown"));
}

}  // namespace
}  // namespace faultlab::server
