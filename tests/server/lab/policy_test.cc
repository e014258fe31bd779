#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "server/lab/policy_settings.h"
#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using core::ErrorCode;

class LabPolicy : public LabFixture {
 protected:
  void Set(const std::function<void(PolicySettings&)>& change) {
    PolicySettings settings = lab_.policy();
    change(settings);
    const auto changed = lab_.ChangePolicy(settings, now_);
    ASSERT_TRUE(changed.ok()) << changed.error().message;
  }
  core::Error BookingRefused(UserId user, Milliseconds in, Milliseconds length) {
    const auto booking = lab_.Book(user, "bench", {now_ + in, now_ + in + length}, now_);
    EXPECT_FALSE(booking.ok());
    return booking.ok() ? core::Error{} : booking.error();
  }
};

TEST_F(LabPolicy, EverySettingIsNamedOnceAndItsDefaultIsWithinItsLimits) {
  std::set<std::string_view> names;
  PolicySettings settings;
  EXPECT_TRUE(CheckSettings(settings).ok());
  for (const PolicySetting& each : kPolicySettings) {
    EXPECT_TRUE(names.insert(each.name).second) << each.name;
    const PolicySettings before = settings;
    SetValue(settings, each, each.most);
    EXPECT_EQ(ValueOf(settings, each), each.most);
    SetValue(settings, each, each.most + 1);
    const core::Status refused = CheckSettings(settings);
    ASSERT_FALSE(refused.ok()) << each.name;
    EXPECT_EQ(refused.error().reason, "whole_number_outside");
    settings = before;
    SetValue(settings, each, each.least - 1);
    EXPECT_FALSE(CheckSettings(settings).ok()) << each.name;
    settings = before;
  }
  settings.session_min = minutes(20);
  settings.session_max = minutes(10);
  EXPECT_EQ(CheckSettings(settings).error().field, "/session_max_s");
}

TEST_F(LabPolicy, AChangeNeedsTheNewestVersionAndIsTold) {
  PolicySettings first = lab_.policy();
  EXPECT_EQ(first.version, 0);
  PolicySettings other = first;
  other.grace = minutes(5);
  ASSERT_TRUE(lab_.ChangePolicy(other, now_).ok());
  EXPECT_EQ(lab_.policy().version, 1);
  first.grace = minutes(9);
  EXPECT_EQ(lab_.ChangePolicy(first, now_).error().code, ErrorCode::kStale);
  EXPECT_EQ(lab_.policy().grace, minutes(5));
  EXPECT_EQ(ChangedSettings(PolicySettings{}, lab_.policy()), "grace_s 180 -> 300");
  const Changes changes = lab_.TakeChanges();
  ASSERT_TRUE(changes.settings.contains(""));
  EXPECT_EQ(changes.settings.at("")->version, 1);
  EXPECT_EQ(Scheduler(Policy{}, lab_.state()).policy().grace, minutes(5)) << "as another member";
}

TEST_F(LabPolicy, RefusalsNameTheLimitsOfThePolicy) {
  AddReadyRigs(2);
  Set([](PolicySettings& policy) {
    policy.booking_max = hours(1);
    policy.booking_min = minutes(20);
    policy.booking_ahead = hours(24 * 7);
    policy.live_bookings_max = 1;
    policy.session_max = minutes(40);
  });
  const auto value = [](const core::Error& error) { return error.parameters.at(0).value; };
  EXPECT_EQ(value(BookingRefused(kAnn, hours(1), hours(2))), "60");
  EXPECT_EQ(value(BookingRefused(kAnn, hours(1), minutes(10))), "20");
  EXPECT_EQ(value(BookingRefused(kAnn, hours(24 * 8), hours(1))), "7");
  Book(kAnn, hours(1), hours(1));
  const core::Error full = BookingRefused(kAnn, hours(5), hours(1));
  EXPECT_EQ(full.reason, "bookings_full");
  EXPECT_EQ(value(full), "1");
  TicketRequest request;
  request.user = kBob;
  request.rig_class = "bench";
  request.want = hours(1);
  EXPECT_EQ(value(lab_.RequestTicket(request, now_).error()), "40");
}

TEST_F(LabPolicy, AClassMayHaveSettingsOfItsOwn) {
  AddReadyRigs(1);
  AddReadyRigs(1, "board");
  PolicySettings boards;
  boards.booking_max = minutes(30);
  boards.offer = minutes(2);
  EXPECT_EQ(lab_.ChangePolicy(boards, now_, "none").error().reason, "no_rig_class");
  ASSERT_TRUE(lab_.ChangePolicy(boards, now_, "board").ok());
  EXPECT_EQ(lab_.ChangePolicy(boards, now_, "board").error().code, ErrorCode::kStale);
  Set([](PolicySettings& policy) { policy.booking_max = hours(1); });
  const auto refusal = [&](const std::string& rig_class) {
    const Interval during{now_ + hours(1), now_ + hours(3)};
    return lab_.CheckBooking(kAnn, rig_class, during, now_).error().parameters.at(0).value;
  };
  EXPECT_EQ(refusal("bench"), "60");
  EXPECT_EQ(refusal("board"), "30");
  TicketRequest request;
  request.user = kBob;
  request.rig_class = "board";
  const auto ticket = std::get<Ticket>(lab_.RequestTicket(request, now_).value());
  EXPECT_EQ(Live(ticket.offered)->claim_until, now_ + minutes(2));
  const std::int64_t version = lab_.TakeChanges().settings.at("board")->version;
  EXPECT_GT(version, 0);
  ASSERT_TRUE(lab_.DropPolicy("board", now_).ok());
  EXPECT_EQ(refusal("board"), "60");
  EXPECT_EQ(lab_.TakeChanges().settings.at("board"), std::nullopt);
  EXPECT_EQ(lab_.DropPolicy("board", now_).error().reason, "no_own_policy");
  EXPECT_EQ(lab_.DropPolicy("", now_).error().reason, "no_own_policy");
  EXPECT_GT(lab_.ChangePolicy(boards, now_, "board").value().version, version);
}

TEST_F(LabPolicy, AShorterLimitKeepsWhatWasPromised) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, hours(1), hours(2));
  Set([](PolicySettings& policy) { policy.booking_max = hours(1); });
  EXPECT_EQ(lab_.state().bookings.at(booking.id).during, booking.during);
}

TEST_F(LabPolicy, ASessionForWhichNobodyWaitsEndsAtTheBoundOfItsExtensions) {
  AddReadyRigs(1);
  Set([](PolicySettings& policy) { policy.extended_max = minutes(25); });
  const Session session = Start(kAnn, minutes(30));
  const WallTime last = session.hard_end + minutes(25);
  while (now_ < last - seconds(20)) Pass(seconds(20));
  ASSERT_NE(Live(session.id), nullptr);
  EXPECT_EQ(Live(session.id)->hard_end, last) << "two whole steps and the rest";
  EXPECT_EQ(lab_.Extend(session.id, now_).error().reason, "extension_limit");
  bool warned = false;
  for (const Notice& notice : lab_.TakeNotices()) {
    if (notice.topic != "warning") continue;
    warned = true;
    EXPECT_EQ(notice.reason, "limit");
  }
  EXPECT_TRUE(warned);
  Pass(seconds(20));
  EXPECT_EQ(Live(session.id), nullptr);
}

TEST_F(LabPolicy, TheWeekCountsWhatIsUsedAndWhatIsPromised) {
  AddReadyRigs(2);
  Set([](PolicySettings& policy) { policy.week_max = hours(3); });
  const Session session = Start(kAnn, minutes(60));
  Pass(minutes(30));
  ASSERT_TRUE(lab_.EndSession(session.id, EndReason::kEnded, "", now_).ok());
  EXPECT_EQ(lab_.WeekUse(kAnn, now_), minutes(30));
  PassChecks();
  Book(kAnn, hours(1), hours(2));
  EXPECT_EQ(lab_.WeekUse(kAnn, now_), minutes(150));
  const core::Error refused = BookingRefused(kAnn, hours(5), minutes(45));
  EXPECT_EQ(refused.reason, "week_full");
  EXPECT_EQ(refused.parameters.at(0).value, "180");
  Book(kBob, hours(5), minutes(45));
  // kNoon is a Monday: a week later another week begins.
  Book(kAnn, hours(24 * 7), minutes(45));
  EXPECT_EQ(lab_.WeekUse(kAnn, now_ + hours(24 * 7)), minutes(45));
}

TEST_F(LabPolicy, TheWeekBoundsASessionAndItsExtensions) {
  AddReadyRigs(1);
  Set([](PolicySettings& policy) { policy.week_max = minutes(40); });
  const Session session = Start(kAnn, minutes(30));
  while (now_ < session.hard_end - seconds(20)) Pass(seconds(20));
  ASSERT_NE(Live(session.id), nullptr);
  EXPECT_LE(Live(session.id)->hard_end - Live(session.id)->charged_from, minutes(40));
  Pass(minutes(15));
  EXPECT_EQ(Live(session.id), nullptr);
  PassChecks();
  TicketRequest again;
  again.user = kAnn;
  again.rig_class = "bench";
  EXPECT_EQ(lab_.RequestTicket(again, now_).error().reason, "week_full");
}

TEST_F(LabPolicy, SimulatorsAndJobsAreNotOfTheWeek) {
  AddReadyRigs(1, "sim", true);
  Set([](PolicySettings& policy) { policy.week_max = minutes(10); });
  TicketRequest request;
  request.user = kAnn;
  request.rig_class = "sim";
  request.want = minutes(60);
  EXPECT_TRUE(lab_.RequestTicket(request, now_).ok());
  EXPECT_EQ(lab_.WeekUse(kAnn, now_), Milliseconds{0});
}

TEST(PolicyWords, LengthsAreSaidInTheLargestWholeUnit) {
  EXPECT_EQ(LengthText(seconds(45)), "45 seconds");
  EXPECT_EQ(LengthText(minutes(3)), "3 minutes");
  EXPECT_EQ(LengthText(minutes(90)), "90 minutes");
  EXPECT_EQ(LengthText(hours(1)), "1 hour");
  EXPECT_EQ(LengthText(hours(24 * 60)), "60 days");
}

TEST(PolicyWords, AWeekBeginsOnMonday) {
  const WallTime monday{Milliseconds{1'769'990'400'000}};  // 2026-02-02 0:00 UTC
  EXPECT_EQ(WeekOf(monday), WeekOf(monday + hours(24 * 7) - Milliseconds{1}));
  EXPECT_EQ(WeekOf(monday) - 1, WeekOf(monday - Milliseconds{1}));
}

}  // namespace
}  // namespace faultlab::server::lab
