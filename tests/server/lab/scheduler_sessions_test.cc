#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using core::ErrorCode;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

class Sessions : public LabFixture {};

TEST_F(Sessions, AnExtensionAskedForIsRefusedWithTheReasonWhenSomebodyWaits) {
  AddReadyRigs(1);
  const Session session = Start(kAnn);
  const WallTime near_end = session.hard_end - minutes(4);
  Scheduler alone = lab_;
  EXPECT_EQ(alone.Extend(session.id, near_end).value().hard_end,
            session.hard_end + lab_.policy().extend_step);
  EXPECT_EQ(alone.Extend(session.id, near_end).error().reason, "extend_early");
  Ask(kBob);
  const core::Error refused = lab_.Extend(session.id, near_end).error();
  EXPECT_EQ(refused.code, ErrorCode::kBusy);
  EXPECT_EQ(refused.reason, "no_extension");
}

TEST_F(Sessions, IdleIsAskedOnlyWhenSomebodyWaitsAndEndsUnansweredAfterAMinute) {
  AddReadyRigs(1);
  const Session session = Start(kAnn, hours(1));
  Pass(minutes(10));
  EXPECT_THAT(Told(kAnn), Not(Contains("idle"))) << "nobody waits";
  Ask(kBob);
  Pass(seconds(1));
  EXPECT_THAT(Told(kAnn), Contains("idle"));
  Pass(lab_.policy().idle_answer - seconds(1) - Milliseconds{1});  // asked when Bob came
  ASSERT_NE(Live(session.id), nullptr);
  Pass(Milliseconds{1});
  EXPECT_EQ(Live(session.id), nullptr);
  EXPECT_THAT(Told(kAnn), ElementsAre("idle_ended")) << "the end is not the question again";
}

TEST_F(Sessions, AnInstructorTakesOverOnlyWithAReason) {
  AddReadyRigs(1);
  const Session ann = Start(kAnn);
  EXPECT_EQ(lab_.TakeOver(ann.id, kTeacher, "", now_).error().field, "reason");
  const auto taken = lab_.TakeOver(ann.id, kTeacher, "the motor screams", now_);
  ASSERT_TRUE(taken.ok());
  EXPECT_EQ(taken.value().user, kTeacher);
  EXPECT_FALSE(Admits(ann.rig, ann.epoch));
  std::vector<Notice> to_ann = lab_.TakeNotices();
  std::erase_if(to_ann, [](const Notice& notice) { return notice.user != kAnn; });
  ASSERT_FALSE(to_ann.empty());
  const Notice& told = to_ann.back();
  EXPECT_EQ(told.topic, "taken_over");
  EXPECT_EQ(told.rig, "bench-1");
  EXPECT_EQ(told.other, kTeacher);
  EXPECT_EQ(told.why, "the motor screams");
}

TEST_F(Sessions, WhoHandsOverIsToldToWhom) {
  AddReadyRigs(1);
  const Session ann = Start(kAnn);
  ASSERT_TRUE(lab_.OfferControl(ann.id, kBob, now_).ok());
  (void)lab_.TakeNotices();
  ASSERT_TRUE(lab_.AcceptControl(ann.id, kBob, now_).ok());
  const std::vector<Notice> told = lab_.TakeNotices();
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0].user, kAnn);
  EXPECT_EQ(told[0].topic, "handed_over");
  EXPECT_EQ(told[0].other, kBob);
  EXPECT_EQ(told[1].topic, "control");
}

TEST_F(Sessions, UseIsChargedToWhoeverHadTheControl) {
  AddReadyRigs(1);
  const Session ann = Start(kAnn, hours(1));
  Pass(minutes(10));
  ASSERT_TRUE(lab_.OfferControl(ann.id, kBob, now_).ok());
  ASSERT_TRUE(lab_.AcceptControl(ann.id, kBob, now_).ok());
  Pass(minutes(5));
  ASSERT_TRUE(lab_.EndSession(ann.id, EndReason::kEnded, "", now_).ok());
  EXPECT_NEAR(lab_.state().usage.at(kAnn).seconds, 600.0, 1.0);
  EXPECT_NEAR(lab_.state().usage.at(kBob).seconds, 300.0, 1.0);
}

TEST_F(Sessions, ChangesHoldEachEndedThingOnceAndThenNothing) {
  AddReadyRigs(1);
  const Session ann = Start(kAnn);
  ASSERT_TRUE(lab_.EndSession(ann.id, EndReason::kEnded, "done", now_).ok());
  const Changes changes = lab_.TakeChanges();
  ASSERT_EQ(changes.sessions.size(), 1u);
  EXPECT_EQ(changes.sessions[0].state, SessionState::kClosed);
  EXPECT_EQ(changes.sessions[0].end_text, "done");
  ASSERT_EQ(changes.tickets.size(), 1u);
  EXPECT_EQ(changes.tickets[0].state, TicketState::kClaimed);
  EXPECT_TRUE(lab_.TakeChanges().empty());
  EXPECT_THAT(lab_.state().sessions, IsEmpty());
}

}  // namespace
}  // namespace faultlab::server::lab
