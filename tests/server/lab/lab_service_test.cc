#include "server/lab/lab_service.h"

#include <gtest/gtest.h>
#include <soci/soci.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/storage/recording_store.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

using core::Done;
using core::ErrorCode;
using core::Status;
using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

/// A bench whose checks wait until the test lets them pass.
class Bench : public RigDuties {
 public:
  void Fence(const RigId& rig, std::uint64_t epoch) override {
    const std::lock_guard lock(mutex_);
    fences_[rig] = epoch;
  }
  void StartCleaning(const Lease& lease) override {
    {
      const std::lock_guard lock(mutex_);
      checks_[lease.rig] = lease.epoch;
    }
    asked_.notify_all();
  }
  bool RunInProgress(const RigId& rig) override {
    const std::lock_guard lock(mutex_);
    return rig == running_;
  }
  void SetRunning(const RigId& rig) {
    const std::lock_guard lock(mutex_);
    running_ = rig;
  }
  /// The service asks for a check after it has answered who caused it: wait for the question.
  void AwaitChecks(std::size_t count) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(asked_.wait_for(lock, seconds(20), [&] { return checks_.size() >= count; }));
  }
  void PassChecks(LabService& service) {
    std::map<RigId, std::uint64_t> checks;
    {
      const std::lock_guard lock(mutex_);
      checks.swap(checks_);
    }
    for (const auto& [rig, epoch] : checks) {
      EXPECT_TRUE(service.CleaningDone(rig, epoch, true, "").ok());
    }
  }
  std::uint64_t fence(const RigId& rig) {
    const std::lock_guard lock(mutex_);
    return fences_[rig];
  }

 private:
  std::mutex mutex_;
  std::condition_variable asked_;
  std::map<RigId, std::uint64_t> fences_;
  std::map<RigId, std::uint64_t> checks_;
  RigId running_;
};

class LabServiceTest : public testing::TestWithParam<Engine> {
 protected:
  LabServiceTest() {
    service_ = OpenService(*database_, bench_);
    EXPECT_TRUE(service_
                    ->Do([](Scheduler& lab, WallTime now) -> Status {
                      for (const char* rig : {"bench-1", "bench-2"}) {
                        (void)lab.AddRig(rig, "bench", false);
                        (void)lab.Claim(rig, "local", now);
                      }
                      return Done{};
                    })
                    .ok());
    bench_->AwaitChecks(2);
    bench_.PassChecks(*service_);
  }
  std::unique_ptr<LabService> OpenService(Database& database, Bench& bench) {
    LabServiceOptions options;
    options.tick = hours(1);  // the tests say when time passes
    auto opened = LabService::Open(database, clock_, bench, options);
    EXPECT_TRUE(opened.ok());
    return std::move(opened).value();
  }
  void Restart() {
    service_.reset();
    database_.Reopen();
    bench_ = std::make_unique<Bench>();
  }
  static core::Result<TicketAnswer> Ask(LabService& service, int user) {
    return service.Do([&](Scheduler& lab, WallTime now) {
      TicketRequest request;
      request.user = UserId{user};
      request.rig_class = "bench";
      return lab.RequestTicket(request, now);
    });
  }
  static core::Result<Session> Start(LabService& service, int user) {
    const auto ticket = Ask(service, user);
    EXPECT_TRUE(ticket.ok());
    return service.Do([&](Scheduler& lab, WallTime now) {
      return lab.AcceptTicket(std::get<Ticket>(ticket.value()).id, UserId{user}, now);
    });
  }

  tests::TestDatabase database_{GetParam()};
  ManualClock clock_;
  struct BenchHolder {
    std::unique_ptr<Bench> bench = std::make_unique<Bench>();
    operator Bench&() { return *bench; }
    Bench* operator->() { return bench.get(); }
    void PassChecks(LabService& service) { bench->PassChecks(service); }
    BenchHolder& operator=(std::unique_ptr<Bench> other) {
      bench = std::move(other);
      return *this;
    }
  } bench_;
  std::unique_ptr<LabService> service_;
};

TEST_P(LabServiceTest, WhatItReloadsIsWhatItHad) {
  ASSERT_TRUE(Start(*service_, 1).ok());
  ASSERT_TRUE(Start(*service_, 2).ok());
  ASSERT_TRUE(Ask(*service_, 3).ok());
  ASSERT_TRUE(service_
                  ->Do([](Scheduler& lab, WallTime now) {
                    return lab.Book(UserId{4}, "bench", {now + hours(5), now + hours(6)}, now);
                  })
                  .ok());
  ASSERT_TRUE(service_
                  ->Do([](Scheduler& lab, WallTime now) {
                    return lab.AddOutage("bench-2", {now + hours(9), now + hours(10)}, "x", now);
                  })
                  .ok());
  ASSERT_TRUE(service_
                  ->Do([](Scheduler& lab, WallTime now) {
                    const SessionId first = lab.state().sessions.begin()->first;
                    (void)lab.RunStarted(first, now);
                    return lab.OfferControl(first, UserId{9}, now);
                  })
                  .ok());
  const LabState had = *service_->state();
  LabState loaded;
  ASSERT_TRUE(database_
                  ->Read([&](Transaction& tx) -> Status {
                    loaded = lab_store::Load(tx);
                    return Done{};
                  })
                  .ok());
  EXPECT_EQ(loaded.rigs, had.rigs);
  EXPECT_EQ(loaded.tickets, had.tickets);
  EXPECT_EQ(loaded.bookings, had.bookings);
  EXPECT_EQ(loaded.sessions, had.sessions);
  EXPECT_EQ(loaded.outages, had.outages);
  EXPECT_EQ(loaded.usage, had.usage);
  EXPECT_EQ(loaded.next_id, had.next_id);
}

TEST_P(LabServiceTest, AfterARestartTheQueueKeepsItsOrderAndReadyRigsAreCheckedAnew) {
  const Session session = Start(*service_, 1).value();
  const auto second = std::get<Ticket>(Ask(*service_, 2).value());
  ASSERT_EQ(second.state, TicketState::kOffered);
  const auto third = std::get<Ticket>(Ask(*service_, 3).value());
  const auto fourth = std::get<Ticket>(Ask(*service_, 4).value());
  service_.reset();
  Restart();
  service_ = OpenService(*database_, bench_);
  const auto state = service_->state();
  EXPECT_EQ(state->tickets.at(second.id).place, 1) << "the offer comes again after the check";
  EXPECT_EQ(state->tickets.at(third.id).place, 2);
  EXPECT_EQ(state->tickets.at(fourth.id).place, 3);
  EXPECT_EQ(state->rigs.at("bench-2").status, RigStatus::kCleaning);
  EXPECT_EQ(state->sessions.at(session.id).epoch, session.epoch);
  EXPECT_EQ(FindBrokenInvariant(*state), "");
  EXPECT_EQ(bench_->fence("bench-1"), session.epoch) << "older epochs are dead on the bench too";
}

TEST_P(LabServiceTest, ARunInProgressKeepsASessionFromBeingIdle) {
  const Session session = Start(*service_, 1).value();
  ASSERT_TRUE(Start(*service_, 2).ok());
  ASSERT_TRUE(Ask(*service_, 3).ok());  // somebody waits
  bench_->SetRunning(session.rig);
  for (int i = 0; i < 10; ++i) {
    clock_.Advance(minutes(1));
    ASSERT_TRUE(service_->TickNow().ok());
  }
  EXPECT_TRUE(service_->state()->sessions.contains(session.id));
  bench_->SetRunning("");
  clock_.Advance(minutes(3));
  ASSERT_TRUE(service_->TickNow().ok());
  EXPECT_FALSE(service_->state()->sessions.at(session.id).run_in_progress);
}

TEST_P(LabServiceTest, ARefusedInputChangesNothingForTheOthersInItsTransaction) {
  const auto refused = service_->Do([](Scheduler& lab, WallTime now) {
    return lab.Book(UserId{1}, "bench", {now - hours(1), now}, now);
  });
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "start");
  EXPECT_TRUE(Ask(*service_, 1).ok());
}

TEST_P(LabServiceTest, TellsUsersThroughStoredEvents) {
  ASSERT_TRUE(Ask(*service_, 1).ok());
  const auto events = service_->EventsSince(UserId{1}, 0, 100).value();
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().topic, "offer");
  EXPECT_TRUE(service_->EventsSince(UserId{1}, events.back().seq, 100).value().empty());
  EXPECT_TRUE(service_->EventsSince(UserId{2}, 0, 100).value().empty());
}

TEST_P(LabServiceTest, TheBenchIsFencedBeforeTheEndOfASessionIsTold) {
  const Session session = Start(*service_, 1).value();
  ASSERT_TRUE(service_
                  ->Do([&](Scheduler& lab, WallTime now) {
                    return lab.EndSession(session.id, EndReason::kEnded, "", now);
                  })
                  .ok());
  EXPECT_GT(bench_->fence(session.rig), session.epoch);
  bench_->AwaitChecks(1);
  bench_.PassChecks(*service_);
  EXPECT_EQ(service_->state()->rigs.at(session.rig).status, RigStatus::kReady);
}

TEST_P(LabServiceTest, TwoHundredWhoAskTogetherAreAllAnsweredConsistently) {
  constexpr int kClients = 200;
  std::vector<std::thread> clients;
  std::atomic<int> answered = 0;
  for (int i = 0; i < kClients; ++i) {
    clients.emplace_back([&, i] { answered += Ask(*service_, 100 + i).ok() ? 1 : 0; });
  }
  for (auto& client : clients) client.join();
  EXPECT_EQ(answered, kClients);
  std::set<int> places;
  for (const auto& [id, ticket] : service_->state()->tickets) {
    if (ticket.state == TicketState::kWaiting) places.insert(ticket.place);
  }
  ASSERT_EQ(places.size(), 198u);
  EXPECT_EQ(*places.begin(), 1);
  EXPECT_EQ(*places.rbegin(), 198);
}

TEST_P(LabServiceTest, AWallClockSetForwardAnHourLengthensNoLeaseAndCutsNone) {
  if (GetParam() == Engine::kPostgresql) return;  // there the clocks are kept by NTP: see the code
  const Session session = Start(*service_, 1).value();
  clock_.JumpWall(hours(1));
  ASSERT_TRUE(service_->TickNow().ok());
  EXPECT_EQ(service_->state()->sessions.at(session.id).hard_end, session.hard_end + hours(1));
  clock_.Advance(seconds(30));
  ASSERT_TRUE(service_->TickNow().ok());
  EXPECT_EQ(service_->state()->sessions.at(session.id).hard_end, session.hard_end + hours(1));
}

INSTANTIATE_TEST_SUITE_P(Engines, LabServiceTest, tests::kBothEngines, tests::EngineName);

core::Result<std::unique_ptr<LabService>> OpenMember(Database& database,
                                                     const ManualClock& clock,
                                                     Bench& bench,
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
  /// Time passes while only these members take their turns.
  void Pass(seconds time, std::initializer_list<LabService*> awake) {
    for (seconds passed{0}; passed < time; passed += seconds(2)) {
      clock_.Advance(seconds(2));
      for (LabService* server : awake) ASSERT_TRUE(server->TickNow().ok());
    }
  }
  /// A person with a session on b's rig, which runs something.
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
  Bench bench_a_;
  Bench bench_b_;
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
  // A rig of the bus that a hears as well is a's now.
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

TEST_F(Members, NobodyIsBuriedForAnOutageOfTheDatabase) {
  const Session session = SessionOnB();
  clock_.Advance(minutes(2));  // nobody could renew
  ASSERT_TRUE(a_->TickNow().ok());
  Pass(seconds(4), {a_.get()});
  ASSERT_TRUE(b_->TickNow().ok());
  Pass(seconds(30), {a_.get(), b_.get()});
  EXPECT_TRUE(a_->state()->sessions.contains(session.id));
  EXPECT_EQ(StateOfRun(), RunState::kRunning);
}

TEST_F(Members, AnIdIsOneServersAlone) {
  Bench third;
  const auto second_b = OpenMember(*other_database_, clock_, third, "b");
  ASSERT_FALSE(second_b.ok());
  EXPECT_EQ(second_b.error().code, ErrorCode::kConflict);
  EXPECT_EQ(second_b.error().field, "server_id");
  b_.reset();
  Pass(seconds(12), {a_.get()});
  EXPECT_TRUE(OpenMember(*other_database_, clock_, third, "b").ok()) << "the place is free";
}

TEST_F(Members, OneWhoseClockIsFarOffTheDatabasesTakesNoPart) {
  Bench third;
  LabServiceOptions options;
  options.tick = hours(1);
  options.member = "c";
  options.alone = false;
  options.clock_error_max = seconds(1);
  const auto off =
      LabService::Open(*database_, clock_, third, options);  // a clock of 2026 for ever
  ASSERT_FALSE(off.ok());
  EXPECT_NE(off.error().message.find("keep it by NTP"), std::string::npos) << off.error().message;
  SystemClock right;
  EXPECT_TRUE(LabService::Open(*database_, right, third, options).ok());
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
  EXPECT_TRUE(a_->TickNow().ok());  // the database ends the frozen turn: 5 s is the patience
  thaw.set_value();
  frozen.join();
}

TEST(TwoServers, ShareOneQueueAndOneSetOfRigs) {
  tests::TestDatabase database(Engine::kPostgresql);
  auto other_database = database.OpenAnother();
  ManualClock clock;
  Bench bench_a;
  Bench bench_b;
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
  ASSERT_TRUE(server_b->TickNow().ok());  // the duties of the first are done before the second
  EXPECT_EQ(bench_b.fence("b-1"), server_b->state()->rigs.at("b-1").epoch);
  // Server b dies in the middle of the check: its rig goes offline, a goes on.
  server_b.reset();
  for (int i = 0; i < 10; ++i) {
    clock.Advance(seconds(2));
    ASSERT_TRUE(server_a->TickNow().ok());
  }
  EXPECT_EQ(server_a->state()->rigs.at("b-1").status, RigStatus::kOffline);
  EXPECT_EQ(FindBrokenInvariant(*server_a->state()), "");
}

TEST(BookingGuard, TheDatabaseItselfRefusesTwoBookingsOnOneRig) {
  for (const Engine engine : {Engine::kSqlite, Engine::kPostgresql}) {
    tests::TestDatabase database(engine);
    const auto put = [&](int id, int start, int end) {
      return database->Write(Durability::kPromise, [&](Transaction& tx) -> Status {
        tx.sql() << "INSERT INTO lab_booking (id, user_id, rig_class, start_ms, end_ms, state, "
                    "rig, session, version, note) VALUES (:id, 1, 'bench', :s, :e, 0, 'bench-1', "
                    "0, 1, '')",
            soci::use(id, "id"), soci::use(start, "s"), soci::use(end, "e");
        return Done{};
      });
    };
    EXPECT_TRUE(put(1, 100, 200).ok());
    EXPECT_EQ(put(2, 150, 250).error().code, ErrorCode::kConflict);
    EXPECT_TRUE(put(3, 200, 300).ok()) << "half-open";
  }
}

}  // namespace
}  // namespace faultlab::server::lab
