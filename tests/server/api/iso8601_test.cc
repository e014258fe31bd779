#include "server/api/iso8601.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

TEST(ParseIso8601, TakesInstantsAndRefusesTheRest) {
  const auto parse = [](const char* text) { return ParseIso8601(text, "t"); };
  const WallTime noon = parse("2026-11-21T12:00:00Z").value();
  EXPECT_EQ(parse("2026-11-21T13:00:00+01:00").value(), noon);
  EXPECT_EQ(parse("2026-11-21T06:30:00.000-05:30").value(), noon);
  EXPECT_EQ(parse("2026-11-21T12:00Z").value(), noon);
  // The hour that happens twice in Berlin is two different instants, an hour apart.
  EXPECT_EQ(parse("2026-10-25T02:30:00+01:00").value() - parse("2026-10-25T02:30:00+02:00").value(),
            std::chrono::hours(1));
  EXPECT_EQ(parse("2026-11-21T12:00:00.5Z").value(), noon + std::chrono::milliseconds(500));
  EXPECT_EQ(parse("2026-11-21T12:00:00.001999999Z").value(), noon + std::chrono::milliseconds(1));
  EXPECT_EQ(parse("9999-12-31T23:59:59.999Z").value() - parse("9999-12-31T00:00Z").value(),
            std::chrono::days(1) - std::chrono::milliseconds(1));
  for (const char* bad : {"",
                          "tomorrow",
                          "2026-11-21",
                          "2026-11-21T12:00:00",
                          "2026-11-21 12:00:00Z",
                          "2026-03-29T02:30:00 Europe/Berlin",
                          "2026-02-29T12:00:00Z",
                          "2026-13-01T12:00:00Z",
                          "2026-11-21T24:00:00Z",
                          "2026-11-21T12:00:00+25:00",
                          "2026-11-21T12:00:00+14:60",
                          "2026-11-21T12:00:00.Z",
                          "2026-11-21T12:00:00.1234567890Z",
                          "2026-11-21T12:00.5Z",
                          "2026-11-21T12:00:60Z",
                          "2026-11-21T12:60:00Z",
                          "2026-11-21T1:00Z",
                          "26-11-21T12:00Z",
                          "+026-11-21T12:00Z",
                          " 2026-11-21T12:00Z",
                          "2026-11-21T12:00:00Zx",
                          "99999-11-21T12:00:00Z"}) {
    EXPECT_FALSE(parse(bad).ok()) << bad;
  }
}

TEST(Iso8601, WritesTheMillisecond) {
  const auto back = [](const char* text) { return Iso8601(ParseIso8601(text, "t").value()); };
  EXPECT_EQ(back("2024-02-29T23:59:59.999Z"), "2024-02-29T23:59:59.999Z");
  EXPECT_EQ(back("0999-01-01T00:00Z"), "0999-01-01T00:00:00.000Z");
  EXPECT_EQ(Iso8601(WallTime(std::chrono::milliseconds(-1))), "1969-12-31T23:59:59.999Z");
}

TEST(Iso8601, HasTheFormOfACalendar) {
  EXPECT_EQ(BasicIso8601(ParseIso8601("2026-01-02T03:04:05.678Z", "t").value()),
            "20260102T030405Z");
}

}  // namespace
}  // namespace faultlab::server
