// Servers that share a PostgreSQL: one dies, one is frozen, one has a wrong clock.
#include "server/lab/members.h"

#include <gtest/gtest.h>
#include <soci/soci.h>

#include <atomic>
#include <future>
#include <thread>

#include "server/lab/lab_service.h"
#include "server/storage/recording_store.h"
#include "tests/server/lab/waiting_bench.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

using core::Done;
using core::ErrorCode;
using core::Status;
using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

core::Result<std::unique_ptr<LabService>> OpenMember(Database& database,
                                                     const ManualClock& clock,
                                                     WaitingBench& bench,
                                                     const std::string& id) {
  LabServiceOptions options;
  options.tick = hours(1);
  options.member = id;
  options.alone = false;
  return LabService::Open(database, clock, bench, options);
}

Status AddRig(LabService& server, const RigId& rig) {
  return server.Do([&](Scheduler& lab, WallTime now) -> Status {
    (void)lab.AddRig(rig, "bench", false);
    return lab.Claim(rig, server.member(), now);
  });
}

/// Two members on one PostgreSQL, one rig each, both ready.
class Members : public testing::Test {
 protected:
  Members() {
    EXPECT_TRUE(AddRig(*a_, "a-1").ok());
    EXPECT_TRUE(AddRig(*b_, "b-1").ok());
    bench_a_.AwaitChecks(1);
    bench_b_.AwaitChecks(1);
    bench_a_.PassChecks(*a_);
    bench_b_.PassChecks(*b_);
  }
  /// Lets time pass while only these members take their turns.
  void Pass(seconds time, std::initializer_list<LabService*> awake) {
    for (seconds passed{0}; passed < time; passed += seconds(2)) {
      clock_.Advance(seconds(2));
      for (LabService* server : awake) ASSERT_TRUE(server->TickNow().ok());
    }
  }
  /// A person with a session on b's rig, with a run in progress.
  Session SessionOnB() {
    Session out;
    for (int user = 1; out.rig != "b-1"; ++user) {
      const auto given = b_->Do([&](Scheduler& lab, WallTime now) -> core::Result<Session> {
        TicketRequest request;
        request.user = UserId{user};
        request.rig_class = "bench";
        const auto ticket = lab.RequestTicket(request, now);
        if (!ticket) return ticket.error();
        return lab.AcceptTicket(std::get<Ticket>(ticket.value()).id, UserId{user}, now);
      });
      EXPECT_TRUE(given.ok()) << given.error().message;
      out = given.value();
    }
    RunRecord run;
    run.id = "run-b";
    run.server_id = "b";
    EXPECT_TRUE(RecordingStore(*database_).Begin(run).ok());
    return out;
  }
  RunState StateOfRun() { return RecordingStore(*database_).Get("run-b").value().state; }

  tests::TestDatabase database_{Engine::kPostgresql};
  std::unique_ptr<Database> other_database_ = database_.OpenAnother();
  ManualClock clock_;
  WaitingBench bench_a_;
  WaitingBench bench_b_;
  std::unique_ptr<LabService> a_ = OpenMember(*database_, clock_, bench_a_, "a").value();
  std::unique_ptr<LabService> b_ = OpenMember(*other_database_, clock_, bench_b_, "b").value();
};

TEST_F(Members, ADeadOnesRigsGoOfflineItsSessionsEndAndItsRunsAreInterrupted) {
  const Session session = SessionOnB();
  b_.reset();
  Pass(seconds(8), {a_.get()});
  EXPECT_TRUE(a_->state()->sessions.contains(session.id)) << "its lease still runs";
  EXPECT_EQ(a_->MemberOf("b-1")->id, "b");
  Pass(seconds(6), {a_.get()});
  const auto state = a_->state();
  EXPECT_EQ(state->rigs.at("b-1").status, RigStatus::kOffline);
  EXPECT_EQ(state->rigs.at("b-1").server, "");
  EXPECT_GT(state->rigs.at("b-1").epoch, session.epoch);
  EXPECT_FALSE(state->sessions.contains(session.id));
  EXPECT_EQ(StateOfRun(), RunState::kInterrupted);
  EXPECT_NE(state->rigs.at("a-1").status, RigStatus::kOffline);
  // A rig of the bus that a receives as well now belongs to a.
  EXPECT_TRUE(AddRig(*a_, "b-1").ok());
  EXPECT_EQ(a_->MemberOf("b-1")->id, "a");
}

TEST_F(Members, OneThatWakesUpIsFencedWritesNothingAndJoinsAnew) {
  const Session session = SessionOnB();
  Pass(seconds(14), {a_.get()});  // b is frozen
  ASSERT_EQ(StateOfRun(), RunState::kInterrupted);
  EXPECT_LE(bench_b_.fence("b-1"), session.epoch) << "nobody can reach it";
  ASSERT_TRUE(b_->TickNow().ok());
  EXPECT_GT(bench_b_.fence("b-1"), session.epoch) << "the first thing that it does";
  EXPECT_FALSE(b_->state()->sessions.contains(session.id));
  const std::vector<core::Sample> late(1);
  EXPECT_FALSE(RecordingStore(*other_database_).AppendChunk("run-b", 0, late).ok());
  EXPECT_TRUE(AddRig(*b_, "b-1").ok()) << "it is a member again and claims its rig";
  EXPECT_EQ(a_->TickNow().ok() ? a_->MemberOf("b-1")->id : "", "b");
}

TEST_F(Members, NobodyIsRemovedForAnOutageOfTheDatabase) {
  const Session session = SessionOnB();
  clock_.Advance(minutes(2));  // no member could renew its lease
  ASSERT_TRUE(a_->TickNow().ok());
  Pass(seconds(4), {a_.get()});
  ASSERT_TRUE(b_->TickNow().ok());
  Pass(seconds(30), {a_.get(), b_.get()});
  EXPECT_TRUE(a_->state()->sessions.contains(session.id));
  EXPECT_EQ(StateOfRun(), RunState::kRunning);
}

TEST_F(Members, AnIdIsOneServersAlone) {
  WaitingBench third;
  const auto second_b = OpenMember(*other_database_, clock_, third, "b");
  ASSERT_FALSE(second_b.ok());
  EXPECT_EQ(second_b.error().code, ErrorCode::kConflict);
  EXPECT_EQ(second_b.error().field, "server_id");
  b_.reset();
  Pass(seconds(12), {a_.get()});
  EXPECT_TRUE(OpenMember(*other_database_, clock_, third, "b").ok()) << "the place is free";
}

TEST_F(Members, OneWhoseClockIsFarOffTheDatabasesTakesNoPart) {
  WaitingBench third;
  LabServiceOptions options;
  options.tick = hours(1);
  options.member = "c";
  options.alone = false;
  options.clock_error_max = seconds(1);
  const auto off = LabService::Open(*database_, clock_, third, options);  // its clock stays in 2026
  ASSERT_FALSE(off.ok());
  EXPECT_NE(off.error().message.find("keep it by NTP"), std::string::npos) << off.error().message;
  SystemClock right;
  EXPECT_TRUE(LabService::Open(*database_, right, third, options).ok());
}

/// The machine's time, set wrong by a person.
class SetClock : public SystemClock {
 public:
  WallTime Wall() const override { return SystemClock::Wall() + Milliseconds(off_ms_.load()); }
  void Set(Milliseconds off) { off_ms_ = off.count(); }

 private:
  std::atomic<std::int64_t> off_ms_{0};
};

TEST(ClockOfAMember, ThatIsSetWrongIsNoticedBeforeItsNextTurnIsStored) {
  tests::TestDatabase database(Engine::kPostgresql);
  WaitingBench bench;
  SetClock clock;
  LabServiceOptions options;
  options.tick = hours(1);
  options.member = "c";
  options.alone = false;
  options.clock_error_max = seconds(1);
  const auto opened = LabService::Open(*database, clock, bench, options);
  ASSERT_TRUE(opened.ok());
  LabService& server = *opened.value();
  for (const Milliseconds off :
       {Milliseconds(hours(-1)), Milliseconds(hours(1)), Milliseconds(-1500), Milliseconds(1500)}) {
    clock.Set(off);
    const Status refused = server.TickNow();
    ASSERT_FALSE(refused.ok()) << off.count() << " ms";
    EXPECT_NE(refused.error().message.find("keep it by NTP"), std::string::npos);
    clock.Set(Milliseconds{0});
    EXPECT_TRUE(server.TickNow().ok()) << "after " << off.count() << " ms";
  }
}

TEST_F(Members, OneThatFreezesWhileItRecordsKeepsNobodyFromRemovingIt) {
  (void)SessionOnB();
  std::promise<void> locked;
  std::promise<void> thaw;
  std::thread frozen([&] {
    const Status lost =
        other_database_->Write(Durability::kTelemetry, [&](Transaction& tx) -> Status {
          std::string state;
          tx.sql() << "SELECT state FROM recording WHERE id = 'run-b' FOR UPDATE",
              soci::into(state);
          locked.set_value();
          thaw.get_future().wait();
          return Done{};
        });
    EXPECT_FALSE(lost.ok()) << "its transaction is gone";
  });
  locked.get_future().wait();
  Pass(seconds(14), {a_.get()});
  EXPECT_EQ(StateOfRun(), RunState::kInterrupted);
  thaw.set_value();
  frozen.join();
}

TEST_F(Members, OneWhosePlaceWasTakenByANewProcessDrivesNothingOn) {
  const Session session = SessionOnB();
  Pass(seconds(14), {a_.get()});  // b is frozen
  WaitingBench bench_anew;
  const auto anew = OpenMember(*other_database_, clock_, bench_anew, "b").value();
  ASSERT_TRUE(AddRig(*anew, "b-1").ok());
  EXPECT_LE(bench_b_.fence("b-1"), session.epoch) << "nobody can reach it";
  const Status woken = b_->TickNow();
  ASSERT_FALSE(woken.ok());
  EXPECT_EQ(woken.error().field, "server_id");
  EXPECT_GT(bench_b_.fence("b-1"), anew->state()->rigs.at("b-1").epoch)
      << "what hangs on it belongs to the new process";
}

TEST_F(Members, AnOutageMakesNobodyANoShowAndFailsNoCheck) {
  const auto booked = a_->Do([&](Scheduler& lab, WallTime now) {
    return lab.Book(UserId{1}, "bench", {now + seconds(2), now + minutes(20)}, now);
  });
  ASSERT_TRUE(booked.ok());
  Pass(seconds(4), {a_.get(), b_.get()});
  const RigId held = a_->state()->bookings.at(booked.value().id).rig;
  const RigId other = held == "a-1" ? "b-1" : "a-1";
  ASSERT_TRUE(a_->Do([&](Scheduler& lab, WallTime now) { return lab.Recheck(other, now); }).ok());
  clock_.Advance(minutes(10));  // the database cannot be reached
  ASSERT_TRUE(a_->TickNow().ok());
  ASSERT_TRUE(b_->TickNow().ok());
  const auto state = b_->state();
  ASSERT_TRUE(state->bookings.contains(booked.value().id));
  EXPECT_EQ(state->bookings.at(booked.value().id).state, BookingState::kHeld);
  EXPECT_TRUE(state->usage.empty()) << "nobody is charged";
  EXPECT_EQ(state->rigs.at(other).status, RigStatus::kCleaning);
  Pass(seconds(180), {a_.get(), b_.get()});
  EXPECT_FALSE(a_->state()->bookings.contains(booked.value().id)) << "the grace goes on, and ends";
}

TEST_F(Members, ARigIsOneMembersAlone) {
  EXPECT_EQ(AddRig(*a_, "b-1").error().code, ErrorCode::kConflict);
}

TEST_F(Members, OneThatFreezesInItsTurnStopsTheOthersForLessThanASecond) {
  std::promise<void> locked;
  std::promise<void> thaw;
  std::thread frozen([&] {
    const Status lost =
        other_database_->Write(Durability::kPromise, [&](Transaction& tx) -> Status {
          (void)lab_store::LockVersion(tx);
          locked.set_value();
          thaw.get_future().wait();
          return Done{};
        });
    EXPECT_FALSE(lost.ok()) << "its transaction is gone";
  });
  locked.get_future().wait();
  EXPECT_TRUE(a_->TickNow().ok());  // the database ends the frozen turn; the patience is 5 s
  thaw.set_value();
  frozen.join();
}

TEST(TwoServers, ShareOneQueueAndOneSetOfRigs) {
  tests::TestDatabase database(Engine::kPostgresql);
  auto other_database = database.OpenAnother();
  ManualClock clock;
  WaitingBench bench_a;
  WaitingBench bench_b;
  auto server_a = OpenMember(*database, clock, bench_a, "a").value();
  auto server_b = OpenMember(*other_database, clock, bench_b, "b").value();
  ASSERT_TRUE(AddRig(*server_a, "a-1").ok());
  ASSERT_TRUE(AddRig(*server_b, "b-1").ok());
  bench_a.AwaitChecks(1);
  bench_b.AwaitChecks(1);
  bench_a.PassChecks(*server_a);
  bench_b.PassChecks(*server_b);
  // Forty users race on both servers for two rigs.
  std::vector<std::thread> clients;
  for (int i = 0; i < 40; ++i) {
    clients.emplace_back([&, i] {
      LabService& server = i % 2 == 0 ? *server_a : *server_b;
      const auto answer = server.Do([&](Scheduler& lab, WallTime now) {
        TicketRequest request;
        request.user = UserId{1 + i};
        request.rig_class = "bench";
        return lab.RequestTicket(request, now);
      });
      EXPECT_TRUE(answer.ok());
    });
  }
  for (auto& client : clients) client.join();
  ASSERT_TRUE(server_a->TickNow().ok());
  ASSERT_TRUE(server_b->TickNow().ok());
  EXPECT_EQ(server_a->state()->tickets, server_b->state()->tickets);
  EXPECT_EQ(server_a->state()->tickets.size(), 40u);
  EXPECT_EQ(FindBrokenInvariant(*server_b->state()), "");
  // A session on b's rig is accepted through a, ended through a, and b does the duties.
  SessionId on_b{};
  for (const auto& [id, session] : server_a->state()->sessions) {
    if (session.rig == "b-1") on_b = id;
  }
  const Session held = server_a->state()->sessions.at(on_b);
  ASSERT_TRUE(server_a
                  ->Do([&](Scheduler& lab, WallTime now) {
                    return lab.AcceptTicket(held.ticket, held.user, now);
                  })
                  .ok());
  ASSERT_TRUE(server_a
                  ->Do([&](Scheduler& lab, WallTime now) {
                    return lab.EndSession(on_b, EndReason::kEnded, "", now);
                  })
                  .ok());
  ASSERT_TRUE(server_b->TickNow().ok());
  ASSERT_TRUE(server_b->TickNow().ok());  // before the duties of the second
  EXPECT_EQ(bench_b.fence("b-1"), server_b->state()->rigs.at("b-1").epoch);
  // Server b dies during the check: its rig goes offline, a continues.
  server_b.reset();
  for (int i = 0; i < 10; ++i) {
    clock.Advance(seconds(2));
    ASSERT_TRUE(server_a->TickNow().ok());
  }
  EXPECT_EQ(server_a->state()->rigs.at("b-1").status, RigStatus::kOffline);
  EXPECT_EQ(FindBrokenInvariant(*server_a->state()), "");
}

}  // namespace
}  // namespace faultlab::server::lab
