// Every time and number that the rules compare with, at the limit itself and a millisecond beside
// it.
#include "server/lab/fair_order.h"
#include "server/lab/timeline.h"
#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using core::ErrorCode;
using testing::Contains;
using testing::Not;

constexpr Milliseconds kOne{1};

class Limits : public LabFixture {
 protected:
  /// At noon again, in a new lab with so many ready rigs.
  void Anew(int rigs) {
    lab_ = Scheduler();
    now_ = kNoon;
    AddReadyRigs(rigs);
  }
  void Allow(const std::function<void(PolicySettings&)>& change) {
    PolicySettings settings = lab_.policy();
    change(settings);
    ASSERT_TRUE(lab_.ChangePolicy(settings, now_).ok());
  }
  void Outage(const RigId& rig, WallTime start, WallTime end) {
    ASSERT_TRUE(lab_.AddOutage(rig, {start, end}, "works", now_).ok());
  }
  /// Why a warning says that a session ends; empty without a warning.
  std::string WarnedOf() {
    for (const Notice& notice : lab_.TakeNotices()) {
      if (notice.topic == "warning") return notice.reason;
    }
    return "";
  }
  std::string ReasonOf(const core::Result<Session>& answer) {
    return answer.ok() ? "" : answer.error().reason;
  }
};

// ---- Queue

TEST_F(Limits, AnOfferIsMadeWhenItsTimeTheLeastAndTheCheckFitBeforeABooking) {
  const Policy& policy = lab_.policy();
  const Milliseconds needed = policy.offer + minutes(10) + policy.cleaning;
  AddReadyRigs(1);
  Book(kBob, needed, minutes(30));
  Scheduler late = lab_;
  EXPECT_EQ(Ask(kAnn, minutes(10)).state, TicketState::kOffered);
  TicketRequest same;
  same.user = kAnn;
  same.rig_class = "bench";
  same.min = minutes(10);
  EXPECT_EQ(std::get<Ticket>(late.RequestTicket(same, now_ + kOne).value()).state,
            TicketState::kWaiting);
}

TEST_F(Limits, WhoAskedAMinuteApartKeepsThePlaceThatWasPromisedWithinAQuarterOfAnHour) {
  const Policy policy;
  Ticket ticket;
  ticket.created = kNoon;
  ticket.first_expected = kNoon + policy.asked_together + policy.keeps_place;
  const WallTime now = kNoon + policy.asked_together;
  EXPECT_TRUE(KeepsPlace(ticket, now, policy));
  EXPECT_FALSE(KeepsPlace(ticket, now - kOne, policy)) << "asked together";
  *ticket.first_expected += kOne;
  EXPECT_FALSE(KeepsPlace(ticket, now, policy)) << "promised for later";
}

// ---- Sessions

TEST_F(Limits, AnExtensionIsForTheLastFiveMinutesToTheMillisecond) {
  AddReadyRigs(1);
  const Session session = Start(kAnn);
  const WallTime last = session.hard_end - minutes(5);
  EXPECT_EQ(ReasonOf(lab_.Extend(session.id, last - kOne)), "extend_early");
  EXPECT_EQ(ReasonOf(lab_.Extend(session.id, last)), "");
}

TEST_F(Limits, AnExtensionIsOfAMinuteAtLeast) {
  AddReadyRigs(1);
  Allow([](PolicySettings& settings) { settings.extended_max = minutes(1); });
  const Session session = Start(kAnn);
  const WallTime last = session.hard_end - minutes(5);
  Scheduler less = lab_;
  PolicySettings settings = less.policy();
  settings.extended_max = minutes(1) - kOne;
  ASSERT_TRUE(less.ChangePolicy(settings, now_).ok());
  EXPECT_EQ(ReasonOf(less.Extend(session.id, last)), "extension_limit");
  less.Tick(last);
  lab_.TakeNotices();
  std::swap(lab_, less);
  EXPECT_EQ(WarnedOf(), "limit");
  std::swap(lab_, less);
  const auto extended = lab_.Extend(session.id, last);
  ASSERT_TRUE(extended.ok()) << extended.error().message;
  EXPECT_EQ(extended.value().hard_end, session.hard_end + minutes(1));
}

TEST_F(Limits, WarningsBeginFiveMinutesBeforeTheEndWhichIsToTheMillisecond) {
  AddReadyRigs(1);
  const Session session = Start(kAnn);
  Ask(kBob);
  (void)Told(kAnn);
  ASSERT_TRUE(lab_.RunStarted(session.id, now_).ok()) << "or nobody would be there";
  lab_.Tick(session.hard_end - minutes(5) - kOne);
  EXPECT_THAT(Told(kAnn), Not(Contains("warning")));
  lab_.Tick(session.hard_end - minutes(5));
  EXPECT_EQ(WarnedOf(), "queue");
  for (const Milliseconds left : {seconds(60), seconds(30)}) {
    lab_.Tick(session.hard_end - left);
    EXPECT_THAT(Told(kAnn), Contains("warning")) << "three in all";
  }
  lab_.Tick(session.hard_end - kOne);
  EXPECT_NE(Live(session.id), nullptr);
  EXPECT_THAT(Told(kAnn), Not(Contains("warning")));
  lab_.Tick(session.hard_end);
  EXPECT_EQ(Live(session.id), nullptr);
}

TEST_F(Limits, ASessionGoesOnWhenMoreThanAMinuteAndTheCheckFitBeforeABooking) {
  for (const bool fits : {false, true}) {
    Anew(1);
    const Session session = Start(kAnn);
    const WallTime tight = session.hard_end + minutes(1) + lab_.policy().cleaning;
    Book(kBob, tight + (fits ? kOne : Milliseconds{0}) - now_, minutes(30));
    (void)lab_.TakeNotices();
    lab_.Tick(session.hard_end - minutes(5));
    EXPECT_EQ(Live(session.id)->hard_end > session.hard_end, fits);
    EXPECT_EQ(WarnedOf(), fits ? "" : "booking");
  }
}

TEST_F(Limits, ASessionEndsForAnOutageThatBeginsAMinuteAndTheCheckBehindIt) {
  AddReadyRigs(1);
  const Session session = Start(kAnn);
  const WallTime tight = session.hard_end + minutes(1) + lab_.policy().cleaning;
  Outage("bench-1", tight, tight + hours(1));
  (void)lab_.TakeNotices();
  lab_.Tick(session.hard_end - minutes(5));
  EXPECT_EQ(WarnedOf(), "outage");
}

TEST_F(Limits, WhoNeedsMoreThanTheGapBeforeABookingDoesNotEndTheSessionBeforeIt) {
  for (const bool fits : {false, true}) {
    Anew(1);
    const Session session = Start(kAnn);
    const WallTime now = session.hard_end - minutes(5);
    // The rig would be free for the least time of Bob and its check from now on.
    const WallTime limit = now + minutes(20) + lab_.policy().cleaning;
    Book(kTeacher, limit + lab_.policy().cleaning - now_, minutes(30));
    Ask(kBob, fits ? minutes(20) : minutes(20) + kOne, minutes(30));
    ASSERT_TRUE(lab_.RunStarted(session.id, now_).ok());
    lab_.Tick(now);
    EXPECT_EQ(Live(session.id)->hard_end == session.hard_end, fits);
  }
}

TEST_F(Limits, PracticeEndsAtTheLatestWhenAnOutageBegins) {
  AddReadyRigs(1, "sim", true);
  Outage("sim-1", now_ + minutes(10), now_ + hours(1));
  EXPECT_EQ(lab_.Practice(kAnn, {"sim-1"}, minutes(10) + kOne, now_).error().code,
            ErrorCode::kBusy);
  EXPECT_TRUE(lab_.Practice(kAnn, {"sim-1"}, minutes(10), now_).ok());
}

TEST_F(Limits, WhatIsHeldEndsAtItsEndAlthoughItsGraceGoesOn) {
  AddReadyRigs(1);
  const Ticket ticket = Ask(kAnn, minutes(5), minutes(5));
  LabState state = lab_.state();
  Session& held = state.sessions.at(ticket.offered);
  held.hard_end = now_ + seconds(10);
  ASSERT_GT(held.claim_until, held.hard_end);
  Scheduler lab(lab_.policy(), state);
  const SessionId id = held.id;
  lab.Tick(now_ + seconds(10) - kOne);
  EXPECT_EQ(lab.state().sessions.at(id).state, SessionState::kHeld);
  lab.Tick(now_ + seconds(10));
  EXPECT_EQ(lab.state().sessions.at(id).state, SessionState::kClosed);
}

// ---- Calendar

TEST_F(Limits, BookingsAreAsShortAndAsFarAsThePolicySays) {
  AddReadyRigs(1);
  const Policy& policy = lab_.policy();
  const auto why_not = [&](Milliseconds in, Milliseconds length) {
    Scheduler copy = lab_;
    const auto booked = copy.Book(kAnn, "bench", {now_ + in, now_ + in + length}, now_);
    return booked.ok() ? "" : booked.error().reason;
  };
  EXPECT_EQ(why_not(hours(1), policy.booking_min), "");
  EXPECT_EQ(why_not(hours(1), policy.booking_min - kOne), "booking_too_short");
  EXPECT_EQ(why_not(hours(1), Milliseconds{0}), "end_before_start");
  EXPECT_EQ(why_not(hours(1), policy.booking_max), "");
  EXPECT_EQ(why_not(hours(1), policy.booking_max + kOne), "booking_too_long");
  EXPECT_EQ(why_not(-kOne, hours(1)), "start_past");
  EXPECT_EQ(why_not(policy.booking_ahead, hours(1)), "");
  EXPECT_EQ(why_not(policy.booking_ahead + kOne, hours(1)), "booking_too_far");
}

TEST_F(Limits, AWeekIsFullWhenItsLastMillisecondIsTaken) {
  AddReadyRigs(1);
  Allow([](PolicySettings& settings) { settings.week_max = hours(1); });
  Scheduler copy = lab_;
  const WallTime start = now_ + hours(1);
  EXPECT_FALSE(copy.Book(kAnn, "bench", {start, start + hours(1) + kOne}, now_).ok());
  EXPECT_TRUE(lab_.Book(kAnn, "bench", {start, start + hours(1)}, now_).ok());
}

TEST_F(Limits, ABookingBeginsAtItsStartEvenIfItsRigIsNotReady) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, hours(1), minutes(30));
  now_ = booking.during.start - seconds(5);
  ASSERT_TRUE(lab_.Recheck("bench-1", now_).ok());
  const auto early = lab_.ClaimBooking(booking.id, kAnn, booking.during.start - kOne);
  EXPECT_EQ(early.error().reason, "booking_early");
  EXPECT_THAT(early.error().message, testing::HasSubstr("2026-02-02 13:00 UTC"));
  EXPECT_EQ(lab_.ClaimBooking(booking.id, kAnn, booking.during.start).error().reason,
            "rig_not_ready");
}

TEST_F(Limits, BookingsMoveAwayFromALostRigAQuarterOfAnHourAhead) {
  AddReadyRigs(2);
  const Booking booking = Book(kAnn, hours(1), minutes(30));
  ASSERT_TRUE(lab_.RigOffline(booking.rig, "no power", now_).ok());
  const WallTime near = booking.during.start - lab_.policy().heal_ahead;
  lab_.Tick(near - kOne);
  EXPECT_EQ(lab_.state().bookings.at(booking.id).rig, booking.rig);
  lab_.Tick(near);
  EXPECT_NE(lab_.state().bookings.at(booking.id).rig, booking.rig);
  EXPECT_GT(lab_.state().bookings.at(booking.id).version, booking.version);
}

TEST_F(Limits, ABookingWithoutARigFallsAtItsEnd) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, minutes(1), minutes(30));
  const auto check_until = [&](WallTime time) {
    // A check that never ends, kept from running into its own limit.
    LabState state = lab_.state();
    Rig& rig = state.rigs.at("bench-1");
    rig.status = RigStatus::kCleaning;
    rig.cleaning_due = time + hours(1);
    Scheduler lab(lab_.policy(), state);
    lab.Tick(time);
    return lab.state().bookings.at(booking.id).state;
  };
  const WallTime use_end = booking.during.end - lab_.policy().cleaning;
  EXPECT_EQ(check_until(use_end - kOne), BookingState::kBooked);
  EXPECT_EQ(check_until(use_end), BookingState::kUnfulfilled);
}

TEST_F(Limits, ADueBookingTakesAnotherRigIfItAndTheCheckFitBeforeTheNextCommitment) {
  for (const bool fits : {false, true}) {
    Anew(2);
    const Booking booking = Book(kAnn, hours(1), minutes(30));
    const RigId other = booking.rig == "bench-1" ? "bench-2" : "bench-1";
    const WallTime needed = booking.during.end;
    Outage(other, needed - (fits ? Milliseconds{0} : kOne), needed + hours(1));
    now_ = booking.during.start - seconds(5);
    lab_.Tick(now_);
    ASSERT_TRUE(lab_.Recheck(booking.rig, now_).ok());
    lab_.Tick(booking.during.start);
    EXPECT_EQ(lab_.state().bookings.at(booking.id).state,
              fits ? BookingState::kHeld : BookingState::kBooked);
  }
}

TEST_F(Limits, ASessionBecomesTheBookingIfItsRigIsFreeUntilTheBookingsEnd) {
  AddReadyRigs(1);
  const Session session = Start(kAnn, minutes(30));
  const Booking own = Book(kAnn, minutes(30) + lab_.policy().cleaning + minutes(1), minutes(30));
  Outage("bench-1", own.during.end, own.during.end + hours(1));
  // The session is still on when its booking begins.
  LabState state = lab_.state();
  state.sessions.at(session.id).hard_end = own.during.start + minutes(1);
  Scheduler lab(lab_.policy(), state);
  lab.Tick(own.during.start);
  EXPECT_EQ(lab.state().bookings.at(own.id).state, BookingState::kClaimed);
  EXPECT_EQ(lab.state().sessions.at(session.id).hard_end, own.during.end - lab_.policy().cleaning);
}

TEST_F(Limits, ASessionWhoseRigIsNotFreeForTheBookingMakesWayAndIsNotItsUsersToEnd) {
  Anew(2);
  const Session session = Start(kAnn, minutes(30));
  const Booking own = Book(kAnn, hours(1), minutes(30));
  Outage(session.rig, own.during.end - kOne, own.during.end + hours(1));
  LabState state = lab_.state();
  state.sessions.at(session.id).hard_end = own.during.start + minutes(1);
  Scheduler lab(lab_.policy(), state);
  lab.Tick(own.during.start);
  EXPECT_EQ(lab.state().bookings.at(own.id).state, BookingState::kHeld);
  EXPECT_NE(lab.state().bookings.at(own.id).rig, session.rig);
  const std::vector<Notice> told = lab.TakeNotices();
  EXPECT_TRUE(std::any_of(told.begin(), told.end(), [&](const Notice& notice) {
    return notice.session == session.id && notice.topic == "booking_elsewhere";
  }));
}

TEST_F(Limits, AClockThatJumpedBeyondABookingCancelsIt) {
  for (const bool over : {false, true}) {
    Anew(1);
    const Booking booking = Book(kAnn, hours(1), minutes(30));
    const WallTime now = booking.during.end - (over ? Milliseconds{0} : kOne);
    lab_.ClockJumped(now - now_, now);
    const auto found = lab_.state().bookings.find(booking.id);
    EXPECT_EQ(found->second.state == BookingState::kUnfulfilled, over);
  }
}

TEST_F(Limits, TheLastFreeStartIsTheOneThatEndsWithTheRange) {
  AddReadyRigs(1);
  const auto starts = [&](Milliseconds range) {
    return NextFree(
        lab_.state(), "bench", {now_, now_ + range}, minutes(30), 1, now_, lab_.policy());
  };
  EXPECT_THAT(starts(minutes(30)), testing::ElementsAre(now_));
  EXPECT_THAT(starts(minutes(30) - kOne), testing::IsEmpty());
}

// ---- Rigs

TEST_F(Limits, ARigInAnOutageThatHasJustBegunIsBookedForAfterIt) {
  AddReadyRigs(1);
  Outage("bench-1", now_, now_ + minutes(30));
  ASSERT_EQ(Status("bench-1"), RigStatus::kMaintenance);
  EXPECT_TRUE(lab_.Book(kAnn, "bench", {now_ + minutes(30), now_ + hours(1)}, now_).ok());
}

TEST_F(Limits, AnOutageIsNotOverAndNotTooFar) {
  AddReadyRigs(1);
  const auto why_not = [&](WallTime start, WallTime end) {
    Scheduler copy = lab_;
    const auto added = copy.AddOutage("bench-1", {start, end}, "works", now_);
    return added.ok() ? "" : added.error().reason;
  };
  EXPECT_EQ(why_not(now_ - hours(1), now_), "outage_past");
  EXPECT_EQ(why_not(now_ + hours(1), now_ + hours(1)), "end_before_start");
  EXPECT_EQ(why_not(now_ - hours(1), now_ + kOne), "");
  const WallTime last = now_ + lab_.policy().booking_ahead;
  EXPECT_EQ(why_not(now_, last), "");
  EXPECT_EQ(why_not(now_, last + kOne), "outage_too_far");
}

TEST_F(Limits, AnOutageShortensASessionWhoseCheckItWouldTouch) {
  for (const bool touches : {false, true}) {
    Anew(1);
    const Session session = Start(kAnn);
    const WallTime checked = session.hard_end + lab_.policy().cleaning;
    const WallTime start = checked - (touches ? kOne : Milliseconds{0});
    Outage("bench-1", start, start + hours(1));
    EXPECT_EQ(Live(session.id)->hard_end, session.hard_end - (touches ? kOne : Milliseconds{0}));
    const auto told = Told(kAnn);
    EXPECT_EQ(std::count(told.begin(), told.end(), "shortened"), touches ? 1 : 0);
  }
}

TEST_F(Limits, ATimeThatHasBegunIsNotCalledFreeAgain) {
  AddReadyRigs(1);
  Book(kAnn, minutes(10), minutes(30));
  const auto added = lab_.AddOutage("bench-1", {now_, now_ + hours(2)}, "works", now_);
  ASSERT_TRUE(added.ok());
  Scheduler earlier = lab_;
  ASSERT_TRUE(lab_.RemoveOutage(added.value().id, now_ + minutes(10)).ok());
  EXPECT_THAT(Told(kAnn), Not(Contains("freed")));
  lab_ = earlier;
  ASSERT_TRUE(lab_.RemoveOutage(added.value().id, now_ + minutes(10) - kOne).ok());
  EXPECT_THAT(Told(kAnn), Contains("freed"));
}

}  // namespace
}  // namespace faultlab::server::lab
