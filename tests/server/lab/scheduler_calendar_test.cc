#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using testing::Contains;

class Calendar : public LabFixture {};

TEST_F(Calendar, GivesABookedRigAtItsHour) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, hours(1), minutes(30));
  Pass(hours(1));
  const auto session = lab_.ClaimBooking(booking.id, kAnn, now_);
  ASSERT_TRUE(session.ok());
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

TEST_F(Calendar, GivesATimeThatBecomesFreeToWhoAskedForItFirst) {
  AddReadyRigs(1);
  const Booking has = Book(kAnn, hours(1), hours(1));
  const Interval during = has.during;
  const auto wait = [&](UserId user, const Interval& when) {
    const auto waiting = lab_.Book(user, "bench", when, now_, {}, /*wait=*/true);
    EXPECT_TRUE(waiting.ok());
    return waiting.value();
  };
  const Booking longer = wait(kTeacher, {during.start, during.end + hours(1)});
  const Booking first = wait(kBob, during);
  const Booking second = wait(kCem, during);
  Book(UserId{50}, hours(2), hours(1));  // in the way of the longer one
  EXPECT_EQ(lab_.Book(kBob, "bench", during, now_).error().reason, "booking_overlaps");
  lab_.TakeNotices();
  ASSERT_TRUE(lab_.CancelBooking(has.id, has.version, now_).ok());
  EXPECT_EQ(lab_.state().bookings.at(first.id).state, BookingState::kBooked);
  EXPECT_THAT(Told(kBob), Contains("time_free"));
  EXPECT_EQ(lab_.state().bookings.at(second.id).state, BookingState::kWaiting);
  EXPECT_EQ(lab_.state().bookings.at(longer.id).state, BookingState::kWaiting);
  Pass(minutes(45) + seconds(1));
  EXPECT_EQ(lab_.Book(UserId{51}, "bench", during, now_, {}, true).error().reason,
            "no_rig_free_then")
      << "nobody would know of it in time";
  EXPECT_EQ(lab_.state().bookings.at(second.id).state, BookingState::kCancelled);
  EXPECT_THAT(Told(kCem), Contains("time_not_free"));
  EXPECT_FALSE(lab_.state().usage.contains(kCem)) << "it costs nothing";
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
  const Booking early = Book(kAnn, hours(1), hours(1));
  const Booking gone = Book(kBob, hours(2), hours(1));
  const Booking moves = Book(kCem, hours(2), hours(1));
  ASSERT_EQ(early.rig, gone.rig) << "first fit";
  ASSERT_NE(moves.rig, gone.rig);
  ASSERT_TRUE(lab_.CancelBooking(gone.id, gone.version, now_).ok());
  lab_.TakeNotices();
  // One rig is taken in the first hour of it, the other in the second.
  const Booking fits = Book(kTeacher, hours(1), hours(2));
  EXPECT_EQ(fits.rig, moves.rig);
  EXPECT_EQ(lab_.state().bookings.at(moves.id).rig, early.rig);
  const std::vector<Notice> told = lab_.TakeNotices();
  const auto found = std::ranges::find(told, "moved", &Notice::topic);
  ASSERT_NE(found, told.end());
  EXPECT_EQ(found->user, kCem);
  EXPECT_EQ(found->reason, "replanned");
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

TEST_F(Calendar, ABookingThatBeginsTakesThePlaceOfAnOffer) {
  AddReadyRigs(2);
  const Booking booking = Book(kAnn, minutes(30), hours(1));
  now_ += minutes(30) - seconds(10);
  ASSERT_EQ(Ask(kAnn, minutes(5)).state, TicketState::kOffered);
  Pass(seconds(10));
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kHeld);
  EXPECT_TRUE(lab_.ClaimBooking(booking.id, kAnn, now_).ok());
}

}  // namespace
}  // namespace faultlab::server::lab
