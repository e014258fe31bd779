#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using core::ErrorCode;
using testing::Contains;

class Calendar : public LabFixture {};

TEST_F(Calendar, GivesABookedRigAtItsHour) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, hours(1), minutes(30));
  EXPECT_EQ(lab_.ClaimBooking(booking.id, kAnn, now_).error().reason, "booking_early");
  Pass(hours(1));
  const auto session = lab_.ClaimBooking(booking.id, kAnn, now_);
  ASSERT_TRUE(session.ok());
  EXPECT_EQ(session.value().hard_end, booking.during.end - lab_.policy().cleaning);
  const auto again = lab_.ClaimBooking(booking.id, kAnn, now_);
  ASSERT_TRUE(again.ok()) << "claiming twice is claiming once";
  EXPECT_EQ(again.value().epoch, session.value().epoch);
}

TEST_F(Calendar, ANoShowLosesTheSlotToTheQueueInTheSameStep) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, hours(1), hours(1));
  Pass(hours(1));
  const Ticket bob = Ask(kBob);
  EXPECT_EQ(bob.state, TicketState::kWaiting);
  Pass(lab_.policy().grace - Milliseconds{1});
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kHeld);
  Pass(Milliseconds{1});
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kNoShow);
  EXPECT_EQ(lab_.state().tickets.at(bob.id).state, TicketState::kOffered);
  EXPECT_GT(lab_.state().usage.at(kAnn).seconds, 0.0) << "it costs";
}

TEST_F(Calendar, TheGraceTimeRunsOnlyFromWhenTheRigIsReady) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, hours(1), hours(1));
  Start(kBob, minutes(59));
  Pass(minutes(59));
  Pass(minutes(1));
  // Bob's check takes a minute longer than planned.
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kBooked);
  now_ += minutes(1);
  PassChecks();
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kHeld);
  Pass(lab_.policy().grace - Milliseconds{1});
  EXPECT_TRUE(lab_.ClaimBooking(booking.id, kAnn, now_).ok());
}

TEST_F(Calendar, GivesATimeThatBecomesFreeToWhoAskedForItFirst) {
  AddReadyRigs(1);
  const Booking has = Book(kAnn, hours(1), hours(1));
  const Interval during = has.during;
  const auto wait = [&](UserId user, const Interval& when) {
    const auto waiting = lab_.Book(user, "bench", when, now_, {}, /*wait=*/true);
    EXPECT_TRUE(waiting.ok());
    EXPECT_EQ(waiting.value().state, BookingState::kWaiting);
    EXPECT_EQ(waiting.value().rig, "");
    return waiting.value();
  };
  const Booking longer = wait(kTeacher, {during.start, during.end + hours(1)});
  const Booking first = wait(kBob, during);
  const Booking second = wait(kCem, during);
  Book(UserId{50}, hours(2), hours(1));  // in the way of the longer one
  EXPECT_EQ(lab_.ClaimBooking(first.id, kBob, now_).error().reason, "no_rig_free_then");
  EXPECT_EQ(lab_.Book(kBob, "bench", during, now_).error().reason, "booking_overlaps");
  lab_.TakeNotices();
  ASSERT_TRUE(lab_.CancelBooking(has.id, has.version, now_).ok());
  EXPECT_EQ(lab_.state().bookings.at(first.id).state, BookingState::kBooked);
  EXPECT_EQ(lab_.state().bookings.at(first.id).rig, "bench-1");
  EXPECT_THAT(Told(kBob), Contains("time_free"));
  EXPECT_EQ(lab_.state().bookings.at(second.id).state, BookingState::kWaiting);
  EXPECT_EQ(lab_.state().bookings.at(longer.id).state, BookingState::kWaiting);
  Pass(hours(1));
  EXPECT_EQ(lab_.state().bookings.at(second.id).state, BookingState::kCancelled);
  EXPECT_THAT(Told(kCem), Contains("time_not_free"));
  EXPECT_FALSE(lab_.state().usage.contains(kCem)) << "it costs nothing";
}

TEST_F(Calendar, ATimeIsNotGivenToWhoCannotKnow) {
  AddReadyRigs(1);
  const Booking has = Book(kAnn, hours(1), hours(1));
  const auto waiting = lab_.Book(kBob, "bench", has.during, now_, {}, /*wait=*/true);
  Pass(minutes(45));
  EXPECT_EQ(lab_.state().bookings.at(waiting.value().id).state, BookingState::kWaiting);
  EXPECT_EQ(lab_.Book(kCem, "bench", has.during, now_ + seconds(1), {}, true).error().reason,
            "no_rig_free_then");
  Pass(seconds(1));
  EXPECT_EQ(lab_.state().bookings.at(waiting.value().id).state, BookingState::kCancelled);
}

TEST_F(Calendar, APromiseWhoseRigIsOutIsBeforeWhoWaits) {
  AddReadyRigs(2);
  const Booking ann = Book(kAnn, hours(2), hours(1));
  const Booking bob = Book(kBob, hours(2), hours(1));
  const auto cem = lab_.Book(kCem, "bench", ann.during, now_, {}, /*wait=*/true);
  ASSERT_TRUE(lab_.Quarantine(ann.rig, "brushes", now_).ok());
  ASSERT_TRUE(lab_.CancelBooking(bob.id, bob.version, now_).ok());
  EXPECT_EQ(lab_.state().bookings.at(cem.value().id).state, BookingState::kWaiting);
  Pass(hours(2));
  EXPECT_EQ(lab_.state().bookings.at(ann.id).state, BookingState::kHeld);
}

TEST_F(Calendar, WhatIsWaitedForIsNoUseOfTheWeek) {
  AddReadyRigs(1);
  const Booking has = Book(kAnn, hours(1), hours(2));
  PolicySettings settings = lab_.policy();
  settings.week_max = hours(3);
  ASSERT_TRUE(lab_.ChangePolicy(settings, now_).ok());
  const auto waiting = lab_.Book(kBob, "bench", has.during, now_, {}, /*wait=*/true);
  EXPECT_EQ(lab_.WeekUse(kBob, now_), Milliseconds{0});
  Book(kBob, hours(4), hours(2));
  ASSERT_TRUE(lab_.CancelBooking(has.id, has.version, now_).ok());
  EXPECT_EQ(lab_.state().bookings.at(waiting.value().id).state, BookingState::kWaiting)
      << "4 h are more than the week has";
}

TEST_F(Calendar, AWaitingTimeComesOnlyInOpenHours) {
  AddReadyRigs(1);
  const Booking has = Book(kAnn, hours(1), hours(1));
  const auto waiting = lab_.Book(kBob, "bench", has.during, now_, {}, /*wait=*/true);
  Window open;
  open.rig_class = "bench";
  open.times = {{now_ + hours(20), now_ + hours(24)}};
  const auto window = lab_.AddWindow(open, now_);
  ASSERT_TRUE(lab_.CancelBooking(has.id, has.version, now_).ok());
  const auto state_of = [&] { return lab_.state().bookings.at(waiting.value().id).state; };
  EXPECT_EQ(state_of(), BookingState::kWaiting);
  ASSERT_TRUE(lab_.RemoveWindow(window.value().id, now_).ok());
  EXPECT_EQ(state_of(), BookingState::kBooked);
}

TEST_F(Calendar, AWaitingTimeCountsAsABookingOfItsUser) {
  AddReadyRigs(1);
  for (const int hour : {1, 5, 9}) Book(kAnn, hours(hour), hours(4));
  const auto wait = [&](int hour) {
    const Interval during{now_ + hours(hour), now_ + hours(hour + 1)};
    return lab_.Book(kBob, "bench", during, now_, {}, /*wait=*/true);
  };
  for (int hour = 1; hour <= lab_.policy().live_bookings_max; ++hour) {
    ASSERT_TRUE(wait(hour).ok());
  }
  EXPECT_EQ(wait(9).error().reason, "bookings_full");
}

TEST_F(Calendar, RacersForTheLastRigGetOneBookingAndOneRefusal) {
  AddReadyRigs(2);
  Book(kAnn, hours(1), hours(1));
  Book(kBob, hours(1), hours(1));
  const auto third = lab_.Book(kCem, "bench", {now_ + minutes(90), now_ + hours(3)}, now_);
  ASSERT_FALSE(third.ok());
  EXPECT_EQ(third.error().code, ErrorCode::kConflict);
}

TEST_F(Calendar, HoursFollowEachOtherWithTheCheckAtTheEndOfEach) {
  AddReadyRigs(1);
  const Booking first = Book(kAnn, hours(1), hours(1));
  const WallTime next = first.during.end;
  EXPECT_FALSE(lab_.Book(kBob, "bench", {next - Milliseconds{1}, next + hours(1)}, now_).ok());
  const auto second = lab_.Book(kBob, "bench", {next, next + hours(1)}, now_);
  ASSERT_TRUE(second.ok());
  EXPECT_TRUE(lab_.Book(kCem, "bench", {now_, first.during.start}, now_).ok());
  Pass(hours(1));
  ASSERT_TRUE(lab_.ClaimBooking(first.id, kAnn, now_).ok());
  Pass(hours(1) - lab_.policy().cleaning);
  EXPECT_EQ(Status("bench-1"), RigStatus::kCleaning);
  PassChecks();
  Pass(lab_.policy().cleaning);
  EXPECT_TRUE(lab_.ClaimBooking(second.value().id, kBob, now_).ok()) << "on time";
}

TEST_F(Calendar, ASessionGoesOnIntoTheNextHourOfItsUserWithoutACheck) {
  AddReadyRigs(1);
  const Booking first = Book(kAnn, hours(1), hours(1));
  const Booking second = Book(kAnn, hours(2), hours(1));
  Pass(hours(1));
  const auto session = lab_.ClaimBooking(first.id, kAnn, now_);
  ASSERT_TRUE(session.ok());
  Pass(minutes(58));
  Pass(minutes(2));
  ASSERT_NE(Live(session.value().id), nullptr);
  EXPECT_EQ(Status("bench-1"), RigStatus::kLeased);
  EXPECT_EQ(lab_.state().bookings.at(second.id).state, BookingState::kClaimed);
  EXPECT_EQ(Live(session.value().id)->hard_end, second.during.end - lab_.policy().cleaning);
}

TEST_F(Calendar, MovesPlansAmongEqualRigsToFitOneMore) {
  AddReadyRigs(2);
  const Booking a = Book(kAnn, hours(1), hours(1));
  const Booking b = Book(kBob, hours(3), hours(1));
  ASSERT_EQ(a.rig, b.rig) << "first fit puts both on one rig";
  const Booking c = Book(kCem, hours(3), hours(1));
  EXPECT_NE(b.rig, c.rig);
  // Ann's rig is free at 14:00 and Cem's is not, but a long booking fits if another one moves.
  const auto d = lab_.Book(kTeacher, "bench", {now_ + minutes(130), now_ + minutes(175)}, now_);
  EXPECT_TRUE(d.ok()) << d.error().message;
}

TEST_F(Calendar, RefusesPastTimesEmptyTimesAndTenYears) {
  AddReadyRigs(1);
  const auto field = [&](Milliseconds from, Milliseconds to) {
    const auto booking = lab_.Book(kAnn, "bench", {now_ + from, now_ + to}, now_);
    return booking.ok() ? std::string("ok") : booking.error().field;
  };
  EXPECT_EQ(field(minutes(-1), minutes(30)), "start");
  EXPECT_EQ(field(hours(1), hours(1)), "end");
  EXPECT_EQ(field(hours(1), minutes(30)), "end");
  EXPECT_EQ(field(hours(1), hours(1) + seconds(1)), "end");
  EXPECT_EQ(field(hours(1), hours(24 * 3650)), "end");
  EXPECT_EQ(field(hours(24 * 3650), hours(24 * 3650 + 1)), "start");
  EXPECT_TRUE(lab_.state().bookings.empty());
}

TEST_F(Calendar, BoundsTheBookingsOfOneUserAndRefusesTwoAtOnce) {
  AddReadyRigs(2);
  Book(kAnn, hours(1), hours(1));
  EXPECT_EQ(lab_.Book(kAnn, "bench", {now_ + minutes(90), now_ + hours(3)}, now_).error().code,
            ErrorCode::kConflict);
  Book(kAnn, hours(3), hours(1));
  Book(kAnn, hours(5), hours(1));
  EXPECT_EQ(lab_.Book(kAnn, "bench", {now_ + hours(7), now_ + hours(8)}, now_).error().code,
            ErrorCode::kConflict);
}

TEST_F(Calendar, ACancellationNeedsTheVersionThatTheUserSaw) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, hours(1), hours(1));
  EXPECT_EQ(lab_.CancelBooking(booking.id, booking.version + 1, now_).error().code,
            ErrorCode::kStale);
  ASSERT_TRUE(lab_.CancelBooking(booking.id, booking.version, now_).ok());
  EXPECT_TRUE(lab_.Book(kBob, "bench", booking.during, now_).ok()) << "its time is free again";
}

TEST_F(Calendar, AHeldBookingCanBeCancelledAndTheRigIsFree) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, hours(1), hours(1));
  Pass(hours(1));
  const std::int64_t version = lab_.state().bookings.at(booking.id).version;
  ASSERT_TRUE(lab_.CancelBooking(booking.id, version, now_).ok());
  EXPECT_EQ(Status("bench-1"), RigStatus::kReady);
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kCancelled);
}

TEST_F(Calendar, AUserWhoAlreadyWorksKeepsTheRigThroughTheBooking) {
  AddReadyRigs(2);
  const Booking booking = Book(kAnn, hours(1), hours(1));
  Pass(minutes(40));
  const Session session = Start(kAnn, minutes(15));
  Pass(minutes(10));
  Pass(minutes(10));
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kClaimed);
  ASSERT_NE(Live(session.id), nullptr);
  EXPECT_EQ(Live(session.id)->hard_end, booking.during.end - lab_.policy().cleaning);
}

TEST_F(Calendar, ClaimingEarlyIsRefusedWithTheTime) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, minutes(30), hours(1));
  const auto early = lab_.ClaimBooking(booking.id, kAnn, now_);
  ASSERT_FALSE(early.ok());
  EXPECT_EQ(early.error().code, ErrorCode::kConflict);
  EXPECT_EQ(early.error().reason, "booking_early");
  EXPECT_NE(early.error().message.find("2026-02-02 12:30 UTC"), std::string::npos)
      << early.error().message;
}

TEST_F(Calendar, ABookingThatBeginsTakesThePlaceOfAnOffer) {
  AddReadyRigs(2);
  const Booking booking = Book(kAnn, minutes(30), hours(1));
  now_ += minutes(30) - seconds(10);
  ASSERT_EQ(Ask(kAnn, minutes(5)).state, TicketState::kOffered);
  Pass(seconds(10));
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kHeld);
  EXPECT_TRUE(lab_.ClaimBooking(booking.id, kAnn, now_).ok());
}

TEST_F(Calendar, PracticeDoesNotTakeABookedSimulator) {
  AddReadyRigs(1, "sim", true);
  ASSERT_TRUE(lab_.Book(kAnn, "sim", {now_ + minutes(10), now_ + minutes(30)}, now_).ok());
  EXPECT_FALSE(lab_.Practice(kBob, {"sim-1"}, minutes(12), now_).ok());
  EXPECT_TRUE(lab_.Practice(kBob, {"sim-1"}, minutes(8), now_).ok());
}

TEST_F(Calendar, ABookingThatAClockStepHasPassedFallsAndSaysSo) {
  AddReadyRigs(1);
  const Booking booking = Book(kBob, minutes(20), minutes(20));
  (void)Told(kBob);
  now_ += hours(1);
  lab_.ClockJumped(hours(1), now_);
  const auto notices = lab_.TakeNotices();
  ASSERT_FALSE(notices.empty());
  EXPECT_EQ(notices.back().topic, "unfulfilled");
  EXPECT_NE(notices.back().text.find("clock"), std::string::npos);
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kUnfulfilled);
}

TEST_F(Calendar, AClockSetForwardAnHourNeitherCutsLeasesNorDoublesThem) {
  AddReadyRigs(1);
  const Session session = Start(kAnn, minutes(30));
  const Booking booking = Book(kBob, minutes(45), hours(2));
  now_ += hours(1);
  lab_.ClockJumped(hours(1), now_);
  Pass(Milliseconds{0});
  ASSERT_NE(Live(session.id), nullptr) << "half an hour was promised";
  EXPECT_EQ(Live(session.id)->hard_end, session.hard_end + hours(1));
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kBooked) << "waits, not lost";
  ASSERT_TRUE(lab_.EndSession(session.id, EndReason::kEnded, "", now_).ok());
  PassChecks();
  EXPECT_TRUE(lab_.ClaimBooking(booking.id, kBob, now_).ok());
}

TEST_F(Calendar, AClockSetBackAnHourDoesNotLengthenLeases) {
  AddReadyRigs(1);
  const Session session = Start(kAnn, minutes(30));
  Ask(kBob);
  now_ -= hours(1);
  lab_.ClockJumped(-hours(1), now_);
  Pass(minutes(31));
  EXPECT_EQ(Live(session.id), nullptr);
}

}  // namespace
}  // namespace faultlab::server::lab
