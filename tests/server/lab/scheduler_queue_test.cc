#include "server/lab/fair_order.h"
#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using core::ErrorCode;
using testing::Contains;
using testing::ElementsAre;

class Queue : public LabFixture {};

TEST_F(Queue, AskingTwiceGivesTheSameTicket) {
  AddReadyRigs(1);
  Start(kAnn);
  const Ticket first = Ask(kBob);
  Pass(seconds(30));
  const Ticket second = Ask(kBob);
  EXPECT_EQ(first.id, second.id);
  EXPECT_EQ(second.created, first.created) << "asking again costs no age";
  EXPECT_EQ(lab_.state().tickets.size() - lab_.TakeChanges().sessions.size(), 1u);
}

TEST_F(Queue, OnesOwnSessionComesBackBeforeAnyCapacityCheck) {
  AddReadyRigs(1);
  const Session session = Start(kAnn);
  Ask(kBob);
  TicketRequest request;
  request.user = kAnn;
  request.rig_class = "bench";
  const auto answer = lab_.RequestTicket(request, now_);
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(std::get<Session>(answer.value()).id, session.id);
}

TEST_F(Queue, OffersTheRigInTheOrderOfAskingAndTellsPlaces) {
  AddReadyRigs(1);
  const Session session = Start(kAnn);
  Pass(seconds(1));
  const Ticket bob = Ask(kBob);
  Pass(seconds(1));
  const Ticket cem = Ask(kCem);
  EXPECT_EQ(bob.place, 1);
  EXPECT_EQ(cem.place, 2);
  ASSERT_TRUE(bob.expected && cem.expected);
  EXPECT_LT(*bob.expected, *cem.expected);
  EXPECT_GE(*bob.expected, session.hard_end);
  ASSERT_TRUE(lab_.EndSession(session.id, EndReason::kEnded, "", now_).ok());
  PassChecks();
  EXPECT_EQ(lab_.state().tickets.at(bob.id).state, TicketState::kOffered);
  EXPECT_EQ(lab_.state().tickets.at(cem.id).place, 1);
  EXPECT_THAT(Told(kBob), Contains("offer"));
}

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
}

TEST_F(QueueBeforeABooking, AGapThatIsAMillisecondShortIsNot) {
  const Gap gap = MakeGap(Milliseconds{1});
  EXPECT_EQ(Ask(kBob, kLeast).expected, OnTheGrid(gap.booking.during.end));
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

TEST_F(Queue, OthersTicketsLookAsIfTheyWereNotThere) {
  AddReadyRigs(1);
  const Ticket ann = Ask(kAnn);
  EXPECT_EQ(lab_.AcceptTicket(ann.id, kBob, now_).error().code, ErrorCode::kNotFound);
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

TEST_F(Queue, WhoHasUsedLessGoesFirstAmongThoseWhoAskTogether) {
  AddReadyRigs(1);
  const Session long_one = Start(kAnn, hours(2));
  Pass(hours(1));
  ASSERT_TRUE(lab_.EndSession(long_one.id, EndReason::kEnded, "", now_).ok());
  const Ticket ann = Ask(kAnn);
  const Ticket bob = Ask(kBob);
  EXPECT_LT(ann.id, bob.id);
  EXPECT_THAT(QueueOrder(lab_.state(), "bench", now_, lab_.policy()), ElementsAre(bob.id, ann.id));
}

TEST_F(Queue, NobodyOvertakesAPersonWhoseFirstEstimateIsNear) {
  AddReadyRigs(1);
  const Session long_one = Start(kAnn, hours(2));
  Pass(hours(1) + minutes(50));
  ASSERT_TRUE(lab_.EndSession(long_one.id, EndReason::kEnded, "", now_).ok());
  PassChecks();
  Start(kCem, minutes(10));
  const Ticket ann = Ask(kAnn);
  ASSERT_LE(*ann.first_expected, now_ + lab_.policy().keeps_place);
  now_ += minutes(2);
  const Ticket bob = Ask(kBob);
  EXPECT_LT(lab_.state().usage.count(kBob), 1u);
  EXPECT_THAT(QueueOrder(lab_.state(), "bench", now_, lab_.policy()), ElementsAre(ann.id, bob.id))
      << "Bob has used less, but Ann was told a time";
}

TEST_F(Queue, AWalkUpStartsOnlyIfItsTimeAndTheCheckFitBeforeTheBooking) {
  AddReadyRigs(1);
  Book(kBob, minutes(20), minutes(30));
  const Ticket too_long = Ask(kAnn, minutes(20));
  EXPECT_EQ(too_long.state, TicketState::kWaiting);
  const Ticket fits = Ask(kCem, minutes(10), hours(1));
  ASSERT_EQ(fits.state, TicketState::kOffered);
  const Session& offered = lab_.state().sessions.at(fits.offered);
  EXPECT_EQ(offered.hard_end, now_ + minutes(20) - lab_.policy().cleaning)
      << "the end is known before accepting";
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

TEST_F(Queue, JobsRunInGapsAreIdempotentAndWaitBehindPeopleOfEqualAge) {
  AddReadyRigs(1);
  const Session busy = Start(kAnn);
  TicketRequest job;
  job.user = kTeacher;
  job.rig_class = "bench";
  job.kind = TicketKind::kJob;
  job.job = "job-1";
  job.weight = -7200;
  job.min = minutes(1);
  job.want = minutes(1);
  const auto first = lab_.RequestTicket(job, now_).value();
  const auto again = lab_.RequestTicket(job, now_).value();
  EXPECT_EQ(std::get<Ticket>(first).id, std::get<Ticket>(again).id);
  const Ticket bob = Ask(kBob);
  ASSERT_TRUE(lab_.EndSession(busy.id, EndReason::kEnded, "", now_).ok());
  PassChecks();
  EXPECT_EQ(lab_.state().tickets.at(bob.id).state, TicketState::kOffered);
  ASSERT_TRUE(lab_.LeaveTicket(bob.id, now_).ok());
  const auto started = lab_.RequestTicket(job, now_).value();
  ASSERT_TRUE(std::holds_alternative<Session>(started)) << "the rig is the job's";
  EXPECT_EQ(std::get<Session>(started).job, "job-1");
  EXPECT_EQ(std::get<Session>(started).ticket, std::get<Ticket>(first).id);
}

TEST_F(Queue, AQuotaBoundsTheWaitingJobsOfOneUser) {
  AddReadyRigs(1);
  Start(kAnn);
  TicketRequest job;
  job.user = kTeacher;
  job.rig_class = "bench";
  job.kind = TicketKind::kJob;
  job.min = job.want = minutes(1);
  for (int i = 0; i < lab_.policy().waiting_jobs_max; ++i) {
    job.job = std::to_string(i);
    ASSERT_TRUE(lab_.RequestTicket(job, now_).ok());
  }
  job.job = "one too many";
  EXPECT_EQ(lab_.RequestTicket(job, now_).error().code, ErrorCode::kBusy);
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
  request.min = minutes(10);
  request.want = minutes(5);
  EXPECT_EQ(lab_.RequestTicket(request, now_).error().field, "want_minutes");
  request.want = hours(24 * 3650);
  EXPECT_EQ(lab_.RequestTicket(request, now_).error().field, "want_minutes");
  EXPECT_TRUE(lab_.state().tickets.empty());
}

TEST_F(Queue, TwoHundredWhoAskInTheSameSecondGetPlacesOneToTheLastWithoutHoles) {
  AddReadyRigs(4);
  for (int i = 0; i < 200; ++i) Ask(UserId{100 + i});
  std::vector<int> places;
  int offered = 0;
  for (const auto& [id, ticket] : lab_.state().tickets) {
    if (ticket.state == TicketState::kOffered) ++offered;
    if (ticket.state == TicketState::kWaiting) places.push_back(ticket.place);
  }
  EXPECT_EQ(offered, 4);
  std::sort(places.begin(), places.end());
  ASSERT_EQ(places.size(), 196u);
  for (int i = 0; i < 196; ++i) EXPECT_EQ(places[static_cast<std::size_t>(i)], i + 1);
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
  EXPECT_EQ(ann.state, SessionState::kActive);
  EXPECT_EQ(LeaseOf(ann).epoch, lab_.state().rigs.at(ann.rig).epoch);
  EXPECT_EQ(LeaseOf(ann).until, now_ + minutes(1));
  EXPECT_EQ(Practise(kBob).error().code, ErrorCode::kBusy);
  lab_.EndPractice(ann.id, now_);
  lab_.EndPractice(ann.id, now_);  // a second call changes nothing
  EXPECT_FALSE(Admits(ann.rig, ann.epoch));
  const Session bob = Practise(kBob).value();
  EXPECT_EQ(bob.rig, ann.rig) << "and no check stands between";
  EXPECT_GT(bob.epoch, ann.epoch);
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

TEST_F(PracticeRuns, AreNobodyElses) {
  const Session ann = Practise(kAnn).value();
  EXPECT_EQ(lab_.OfferControl(ann.id, kBob, now_).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(lab_.TakeOver(ann.id, kTeacher, "why", now_).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace faultlab::server::lab
