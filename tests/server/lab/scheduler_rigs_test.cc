#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using core::ErrorCode;
using testing::Contains;
using testing::HasSubstr;

class Rigs : public LabFixture {};

TEST_F(Rigs, ARenewedLeaseRevokesWhatItHeldAndTheSessionGoesOn) {
  AddReadyRigs(1);
  const Session session = Start(kAnn);
  ASSERT_TRUE(lab_.RenewLease("bench-1", now_).ok());
  const Session* renewed = Live(session.id);
  ASSERT_NE(renewed, nullptr);
  EXPECT_GT(renewed->epoch, session.epoch);
  EXPECT_FALSE(Admits("bench-1", session.epoch));
  EXPECT_TRUE(Admits("bench-1", renewed->epoch));
  EXPECT_EQ(renewed->hard_end, session.hard_end);
  EXPECT_EQ(Status("bench-1"), RigStatus::kLeased);
}

TEST_F(Rigs, ADeadRigIsOfferedToNobody) {
  AddReadyRigs(1);
  ASSERT_TRUE(lab_.RigOffline("bench-1", "no heartbeat", now_).ok());
  const Ticket ticket = Ask(kAnn);
  EXPECT_EQ(ticket.state, TicketState::kWaiting);
  EXPECT_EQ(ticket.expected, std::nullopt) << "no rig in sight: no promise";
}

TEST_F(Rigs, QuarantineOutlivesALostLinkAndNeedsARelease) {
  AddReadyRigs(1);
  ASSERT_TRUE(lab_.Quarantine("bench-1", "smells", now_).ok());
  ASSERT_TRUE(lab_.RigOffline("bench-1", "unplugged", now_).ok());
  ASSERT_TRUE(lab_.Claim("bench-1", kServer, now_).ok());
  EXPECT_EQ(Status("bench-1"), RigStatus::kQuarantined);
  ASSERT_TRUE(lab_.Release("bench-1", now_).ok());
  EXPECT_EQ(Status("bench-1"), RigStatus::kCleaning);
  EXPECT_EQ(lab_.Release("bench-1", now_).error().code, ErrorCode::kConflict);
}

TEST_F(Rigs, ACheckThatIsPutOffWaitsAndIsNoFailure) {
  AddReadyRigs(1);
  ASSERT_TRUE(lab_.Recheck("bench-1", now_).ok());
  const std::uint64_t epoch = lab_.state().rigs.at("bench-1").epoch;
  EXPECT_EQ(lab_.CheckPutOff("bench-1", epoch - 1, "", now_).error().code, ErrorCode::kStale);
  ASSERT_TRUE(lab_.CheckPutOff("bench-1", epoch, "the rig is held by b/1", now_).ok());
  EXPECT_EQ(Status("bench-1"), RigStatus::kOffline);
  EXPECT_EQ(lab_.CheckPutOff("bench-1", epoch, "", now_).error().code, ErrorCode::kStale);
}

TEST_F(Rigs, ARigThatIsLostInItsCheckIsCheckedAsSoonAsItIsBack) {
  AddReadyRigs(1);
  ASSERT_TRUE(lab_.Recheck("bench-1", now_).ok());
  ASSERT_TRUE(lab_.RigOffline("bench-1", "unplugged", now_).ok());
  ASSERT_TRUE(lab_.RigOffline("bench-1", "its key is not here", now_).ok());
  EXPECT_EQ(lab_.state().rigs.at("bench-1").reason, "its key is not here");
  ASSERT_TRUE(lab_.Claim("bench-1", kServer, now_).ok());
  EXPECT_EQ(Status("bench-1"), RigStatus::kCleaning);
}

TEST_F(Rigs, ARigThatIsNotAheadOfTheLabNeedsNoAdoption) {
  AddReadyRigs(1);
  const Session ann = Start(kAnn);
  for (const std::uint64_t seen : {std::uint64_t{0}, ann.epoch}) {
    const auto refused = lab_.Adopt("bench-1", seen, now_);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  }
  EXPECT_NE(Live(ann.id), nullptr);
  // The rig is out of order although the epochs are equal, because another lab has used it.
  ASSERT_TRUE(lab_.Quarantine("bench-1", "it has seen this epoch of another lab", now_).ok());
  const std::uint64_t epoch = lab_.state().rigs.at("bench-1").epoch;
  ASSERT_TRUE(lab_.Adopt("bench-1", epoch, now_).ok());
  EXPECT_EQ(lab_.state().rigs.at("bench-1").epoch, epoch + 1);
}

TEST_F(Rigs, AdoptionEndsTheSessionOfTheOlderLabUncharged) {
  AddReadyRigs(1);
  const Session ann = Start(kAnn);
  Pass(minutes(10));
  ASSERT_TRUE(lab_.Adopt("bench-1", ann.epoch + 40, now_).ok());
  EXPECT_EQ(Live(ann.id), nullptr);
  EXPECT_FALSE(lab_.state().usage.contains(kAnn));
  EXPECT_THAT(Told(kAnn), Contains("rig_failed"));
  EXPECT_EQ(Status("bench-1"), RigStatus::kCleaning);
  EXPECT_GT(lab_.state().rigs.at("bench-1").epoch, ann.epoch + 40);
}

TEST_F(Rigs, WhoseHeldRigIsLostIsToldWhyTheBookingMoved) {
  AddReadyRigs(3);
  const Booking booking = Book(kAnn, minutes(10), minutes(30));
  Pass(minutes(10));
  const auto rig = [&] { return lab_.state().bookings.at(booking.id).rig; };
  const auto moved = [&](const std::string& from) {
    EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kHeld);
    EXPECT_NE(rig(), from);
    const std::vector<Notice> told = lab_.TakeNotices();
    const auto found = std::ranges::find(told, "moved", &Notice::topic);
    return found == told.end() ? "nothing" : found->reason + ": " + found->why;
  };
  std::string before = rig();
  ASSERT_TRUE(lab_.RigOffline(before, "its server does not answer", now_).ok());
  EXPECT_EQ(moved(before), "rig_out: its server does not answer");
  before = rig();
  ASSERT_TRUE(lab_.Quarantine(before, "smoke", now_).ok());
  EXPECT_EQ(moved(before), "rig_out: smoke");
}

TEST_F(Rigs, WhoseHeldRigIsNeededByAnOutageIsToldThatTheBookingMovedForIt) {
  AddReadyRigs(2);
  const Booking booking = Book(kAnn, minutes(10), minutes(30));
  Pass(minutes(10));
  const std::string before = lab_.state().bookings.at(booking.id).rig;
  ASSERT_TRUE(lab_.AddOutage(before, {now_ + minutes(2), now_ + hours(1)}, "brushes", now_).ok());
  Pass(minutes(2));
  const Booking& after = lab_.state().bookings.at(booking.id);
  EXPECT_EQ(after.state, BookingState::kHeld);
  EXPECT_NE(after.rig, before);
  const std::vector<Notice> told = lab_.TakeNotices();
  const auto found = std::ranges::find(told, "moved", &Notice::topic);
  ASSERT_NE(found, told.end());
  EXPECT_EQ(found->reason + ": " + found->why, "outage: brushes");
}

TEST_F(Rigs, ABookingWithoutAnyRigFallsUnchargedAtItsStartAndSaysWhy) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, minutes(10), minutes(30));
  ASSERT_TRUE(lab_.RigOffline("bench-1", "no heartbeat", now_).ok());
  Pass(minutes(9));
  EXPECT_EQ(lab_.state().bookings.at(booking.id).state, BookingState::kBooked);
  Pass(minutes(1));
  const Changes changes = lab_.TakeChanges();
  ASSERT_EQ(changes.bookings.size(), 1u);
  EXPECT_EQ(changes.bookings[0].state, BookingState::kUnfulfilled);
  EXPECT_THAT(changes.bookings[0].note, HasSubstr("no heartbeat"));
  EXPECT_FALSE(lab_.state().usage.contains(kAnn));
}

TEST_F(Rigs, AnOutageShortensTheSessionAndMovesOrCancelsBookings) {
  AddReadyRigs(2);
  const Booking moves = Book(kBob, hours(2), minutes(30));
  const Session session = Start(kAnn, hours(1));
  ASSERT_TRUE(
      lab_.AddOutage(session.rig, {now_ + minutes(20), now_ + hours(4)}, "works", now_).ok());
  const Booking moved = lab_.state().bookings.at(moves.id);
  EXPECT_EQ(moved.state, BookingState::kBooked);
  EXPECT_NE(moved.rig, session.rig);
  EXPECT_THAT(Told(kBob), Contains("moved"));
  const auto outage = lab_.AddOutage(moved.rig, {now_ + hours(1), now_ + hours(4)}, "works", now_);
  ASSERT_TRUE(outage.ok());
  EXPECT_THAT(Told(kBob), Contains("unfulfilled"));
  ASSERT_TRUE(lab_.RemoveOutage(outage.value().id, now_).ok());
  const std::vector<Notice> told = lab_.TakeNotices();
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].user, kBob);
  EXPECT_EQ(told[0].topic, "freed");
  EXPECT_EQ(told[0].time, moves.during.start);
}

TEST_F(Rigs, WhomAnOutageShortensIsToldOnceHowLongIsReallyLeftAndWhy) {
  AddReadyRigs(1);
  const Session session = Start(kAnn, hours(1));
  Ask(kBob);
  (void)lab_.TakeNotices();
  ASSERT_TRUE(
      lab_.AddOutage("bench-1", {now_ + minutes(2), now_ + hours(1)}, "bearing", now_).ok());
  std::vector<Notice> told = lab_.TakeNotices();
  std::erase_if(told, [](const Notice& notice) { return notice.user != kAnn; });
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].topic, "shortened");
  EXPECT_EQ(told[0].text, "90 s left: planned outage: bearing");
  EXPECT_EQ(told[0].reason, "outage");
  EXPECT_EQ(told[0].why, "bearing");
  EXPECT_EQ(told[0].time, Live(session.id)->hard_end);
  Pass(seconds(40));
  told = lab_.TakeNotices();
  std::erase_if(told, [](const Notice& notice) { return notice.user != kAnn; });
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].topic, "warning");
  EXPECT_EQ(told[0].reason, "outage") << "although somebody waits";
}

TEST_F(Rigs, OnlyAFailedCheckIsOneWhateverAPersonWrites) {
  AddReadyRigs(1);
  ASSERT_TRUE(lab_.Quarantine("bench-1", std::string(kCheckFailedText) + "x", now_).ok());
  EXPECT_FALSE(lab_.state().rigs.at("bench-1").check_failed);
}

TEST_F(Rigs, RefusesAnOutageThatIsPlannedAlready) {
  AddReadyRigs(2);
  const auto plan = [&](const char* rig, Milliseconds from, Milliseconds to) {
    return lab_.AddOutage(rig, {now_ + from, now_ + to}, "works", now_);
  };
  const auto first = plan("bench-1", hours(1), hours(3));
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(plan("bench-1", hours(1), hours(3)).error().reason, "outage_planned");
  EXPECT_EQ(plan("bench-1", hours(2), hours(3)).error().code, ErrorCode::kConflict);
  EXPECT_TRUE(plan("bench-1", hours(2), hours(4)).ok()) << "it is longer";
  EXPECT_TRUE(plan("bench-2", hours(1), hours(3)).ok());
  ASSERT_TRUE(lab_.RemoveOutage(first.value().id, now_).ok());
  EXPECT_TRUE(plan("bench-1", hours(1), hours(3)).ok());
}

TEST_F(Rigs, AfterARestartLeasesStandChecksBeginAnewAndCutRunsAreNotCharged) {
  AddReadyRigs(2);
  const Session ann = Start(kAnn);
  const Session bob = Start(kBob);
  ASSERT_TRUE(lab_.RunStarted(ann.id, now_).ok());
  Pass(minutes(5));
  ASSERT_TRUE(lab_.EndSession(bob.id, EndReason::kEnded, "", now_).ok());
  const std::uint64_t check = lab_.state().rigs.at(bob.rig).epoch;
  Scheduler restarted(lab_.policy(), lab_.state());
  restarted.Recover(now_);
  EXPECT_EQ(restarted.state().sessions.at(ann.id).epoch, ann.epoch);
  EXPECT_EQ(restarted.state().rigs.at(ann.rig).epoch, ann.epoch);
  EXPECT_EQ(restarted.state().rigs.at(bob.rig).status, RigStatus::kCleaning);
  EXPECT_GT(restarted.state().rigs.at(bob.rig).epoch, check);
  ASSERT_TRUE(restarted.EndSession(ann.id, EndReason::kEnded, "", now_).ok());
  EXPECT_DOUBLE_EQ(restarted.state().usage.at(kAnn).seconds, 0.0);
}

}  // namespace
}  // namespace faultlab::server::lab
