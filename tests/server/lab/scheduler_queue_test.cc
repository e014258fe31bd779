#include "server/lab/fair_order.h"
#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using core::ErrorCode;

class Queue : public LabFixture {};

/// One rig, Ann on it, and a booking so long after her that Bob's offer, his least time and the
/// check fit between, or miss it by `short_by`.
struct Gap {
  WallTime starts_at;
  Booking booking;
};

class QueueBeforeABooking : public Queue {
 protected:
  Gap MakeGap(Milliseconds short_by) {
    AddReadyRigs(1);
    const Policy& policy = lab_.policy();
    const WallTime free_at = Start(kAnn).hard_end + policy.cleaning;
    const WallTime booked_at = free_at + policy.offer + kLeast + policy.cleaning - short_by;
    return {free_at, Book(kTeacher, booked_at - now_, minutes(30))};
  }
  static WallTime OnTheGrid(WallTime time) {
    constexpr Milliseconds kGrid{10'000};
    const auto beyond = time.time_since_epoch() % kGrid;
    return beyond == Milliseconds{0} ? time : time + kGrid - beyond;
  }

  static constexpr Milliseconds kLeast = minutes(10);
};

TEST_F(QueueBeforeABooking, AGapThatFitsToTheMillisecondIsPromised) {
  const Gap gap = MakeGap(Milliseconds{0});
  EXPECT_EQ(Ask(kBob, kLeast).expected, OnTheGrid(gap.starts_at));
  lab_ = Scheduler();
  const Gap shorter = MakeGap(Milliseconds{1});
  EXPECT_EQ(Ask(kBob, kLeast).expected, OnTheGrid(shorter.booking.during.end));
}

TEST_F(QueueBeforeABooking, TheNextBeginsWhenThePersonAheadAndTheCheckAreDone) {
  const Gap gap = MakeGap(Milliseconds{0});
  Ask(kBob, kLeast, minutes(30));
  const WallTime after = gap.booking.during.end;
  EXPECT_EQ(Ask(kCem, kLeast).expected, OnTheGrid(after))
      << "Bob may want more than what the gap holds; nobody is promised its rest";
}

TEST_F(Queue, AnOfferRunsOutComesBackOnceAndIsThenDropped) {
  AddReadyRigs(1);
  const Ticket ticket = Ask(kAnn);
  EXPECT_EQ(ticket.state, TicketState::kOffered);
  EXPECT_EQ(lab_.state().sessions.at(ticket.offered).epoch, 0u) << "an offer is no lease";
  Pass(lab_.policy().offer);
  EXPECT_EQ(lab_.state().tickets.at(ticket.id).state, TicketState::kOffered) << "offered again";
  Pass(lab_.policy().offer);
  EXPECT_EQ(lab_.state().tickets.at(ticket.id).state, TicketState::kExpired);
  EXPECT_EQ(Status("bench-1"), RigStatus::kReady) << "nobody touched it: no check needed";
}

TEST_F(Queue, ALeftOfferGoesToTheNextInTheSameStep) {
  AddReadyRigs(1);
  const Ticket ann = Ask(kAnn);
  const Ticket bob = Ask(kBob);
  ASSERT_TRUE(lab_.LeaveTicket(ann.id, now_).ok());
  EXPECT_EQ(lab_.state().tickets.at(bob.id).state, TicketState::kOffered);
}

TEST_F(Queue, PastUseCountsButFadesAndAgeBeatsEverythingInTheEnd) {
  const Policy policy;
  Ticket ticket;
  ticket.created = kNoon;
  const double fresh = FairScore(ticket, 0.0, kNoon, policy);
  const double heavy = FairScore(ticket, 36'000.0, kNoon, policy);
  EXPECT_DOUBLE_EQ(fresh, policy.fresh_user_bonus_s);
  EXPECT_LT(heavy, fresh / 10);
  EXPECT_DOUBLE_EQ(FairScore(ticket, policy.use_quota_s, kNoon, policy), fresh / 2);
  EXPECT_GT(FairScore(ticket, 1e9, kNoon + minutes(31), policy), fresh);
  const Usage usage{kAnn, 3600.0, kNoon};
  EXPECT_NEAR(DecayedUse(usage, kNoon + policy.half_life, policy), 1800.0, 1e-9);
}

TEST_F(Queue, ElasticSimulatorsAreGrantedAtOnceUpToTheirNumber) {
  AddReadyRigs(2, "sim", true);
  const auto ask = [&](UserId user) {
    TicketRequest request;
    request.user = user;
    request.rig_class = "sim";
    return lab_.RequestTicket(request, now_).value();
  };
  EXPECT_TRUE(std::holds_alternative<Session>(ask(kAnn)));
  EXPECT_TRUE(std::holds_alternative<Session>(ask(kBob)));
  EXPECT_TRUE(std::holds_alternative<Ticket>(ask(kCem)));
  EXPECT_GT(std::get<Session>(ask(kAnn)).epoch, 0u);
}

TEST_F(Queue, AJobIsAskedForOnceHoweverOftenAlsoWhileItRuns) {
  AddReadyRigs(1);
  const Session busy = Start(kAnn);
  const TicketRequest job = JobOf(kTeacher);
  const auto first = lab_.RequestTicket(job, now_).value();
  const auto again = lab_.RequestTicket(job, now_).value();
  EXPECT_EQ(std::get<Ticket>(first).id, std::get<Ticket>(again).id);
  ASSERT_TRUE(lab_.EndSession(busy.id, EndReason::kEnded, "", now_).ok());
  PassChecks();
  const auto started = lab_.RequestTicket(job, now_).value();
  ASSERT_TRUE(std::holds_alternative<Session>(started)) << "the rig is the job's";
  EXPECT_EQ(std::get<Session>(started).job, "job-1");
  EXPECT_EQ(std::get<Session>(started).ticket, std::get<Ticket>(first).id);
}

TEST_F(Queue, AQuotaBoundsTheWaitingJobsOfOneUser) {
  AddReadyRigs(1);
  Start(kAnn);
  for (int i = 0; i < lab_.policy().waiting_jobs_max; ++i) {
    ASSERT_TRUE(lab_.RequestTicket(JobOf(kTeacher, std::to_string(i)), now_).ok());
  }
  EXPECT_EQ(lab_.RequestTicket(JobOf(kTeacher, "one too many"), now_).error().code,
            ErrorCode::kBusy);
}

TEST_F(Queue, RefusesUnknownClassesAndUnreasonableTimes) {
  AddReadyRigs(1);
  TicketRequest request;
  request.user = kAnn;
  request.rig_class = "unicorn";
  EXPECT_EQ(lab_.RequestTicket(request, now_).error().code, ErrorCode::kNotFound);
  request.rig_class = "bench";
  request.min = minutes(-5);
  EXPECT_EQ(lab_.RequestTicket(request, now_).error().field, "min_minutes");
  request.kind = TicketKind::kJob;
  request.min = request.want = Milliseconds{0};
  EXPECT_EQ(lab_.RequestTicket(request, now_).error().field, "min_minutes") << "a job of no length";
  request.kind = TicketKind::kPerson;
  request.min = minutes(10);
  request.want = minutes(5);
  EXPECT_EQ(lab_.RequestTicket(request, now_).error().field, "want_minutes");
  request.want = hours(24 * 3650);
  EXPECT_EQ(lab_.RequestTicket(request, now_).error().field, "want_minutes");
  EXPECT_TRUE(lab_.state().tickets.empty());
}

class PracticeRuns : public LabFixture {
 protected:
  PracticeRuns() {
    for (const char* id : {"sim-1", "sim-2"}) {
      EXPECT_TRUE(lab_.AddRig(id, "sim", true).ok());
      EXPECT_TRUE(lab_.Claim(id, kServer, now_).ok());
    }
  }
  core::Result<Session> Practise(UserId user) {
    return lab_.Practice(user, {"sim-1", "sim-2"}, minutes(1), now_);
  }
};

TEST_F(PracticeRuns, GetALeaseEachAtOnceUntilNoSimulatorIsFree) {
  const Session ann = Practise(kAnn).value();
  const Session again = Practise(kAnn).value();
  EXPECT_NE(ann.rig, again.rig);
  EXPECT_EQ(LeaseOf(ann).until, now_ + minutes(1));
  EXPECT_EQ(Practise(kBob).error().code, ErrorCode::kBusy);
  lab_.EndPractice(ann.id, now_);
  lab_.EndPractice(ann.id, now_);  // a second call changes nothing
  EXPECT_EQ(Practise(kBob).value().rig, ann.rig) << "and no check stands between";
  EXPECT_THAT(Told(kAnn), testing::IsEmpty());
}

TEST_F(PracticeRuns, EndByTimeAndARestartAndNeverByIdlenessOrExtension) {
  const Session ann = Practise(kAnn).value();
  Pass(minutes(2));
  EXPECT_EQ(Live(ann.id), nullptr);
  const Session bob = Practise(kBob).value();
  Scheduler restarted(lab_.policy(), lab_.state());
  restarted.Recover(now_);
  EXPECT_EQ(restarted.state().rigs.at(bob.rig).status, RigStatus::kReady);
  EXPECT_GT(restarted.state().rigs.at(bob.rig).epoch, bob.epoch);
  EXPECT_TRUE(lab_.state().usage.empty()) << "practice is free";
}

TEST_F(PracticeRuns, AndSessionsOfJobsAreNobodyElses) {
  AddReadyRigs(1);
  const auto of_job = lab_.RequestTicket(JobOf(kAnn), now_).value();
  for (const SessionId id : {Practise(kAnn).value().id, std::get<Session>(of_job).id}) {
    EXPECT_EQ(lab_.OfferControl(id, kBob, now_).error().code, ErrorCode::kNotFound);
    EXPECT_EQ(lab_.TakeOver(id, kTeacher, "why", now_).error().code, ErrorCode::kNotFound);
  }
}

}  // namespace
}  // namespace faultlab::server::lab
