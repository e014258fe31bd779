#include "server/lab/lab_service.h"

#include <gtest/gtest.h>
#include <soci/soci.h>

#include <atomic>
#include <stdexcept>

#include "server/storage/recording_store.h"
#include "tests/server/lab/waiting_bench.h"
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
  std::unique_ptr<LabService> OpenService(Database& database, WaitingBench& bench) {
    LabServiceOptions options;
    options.tick = hours(1);  // the tests advance the time
    auto opened = LabService::Open(database, clock_, bench, options);
    EXPECT_TRUE(opened.ok());
    return std::move(opened).value();
  }
  void Restart() {
    service_.reset();
    database_.Reopen();
    bench_ = std::make_unique<WaitingBench>();
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
    std::unique_ptr<WaitingBench> bench = std::make_unique<WaitingBench>();
    operator WaitingBench&() { return *bench; }
    WaitingBench* operator->() { return bench.get(); }
    void PassChecks(LabService& service) { bench->PassChecks(service); }
    BenchHolder& operator=(std::unique_ptr<WaitingBench> other) {
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

TEST_P(LabServiceTest, TellsUsersThroughStoredEvents) {
  ASSERT_TRUE(Ask(*service_, 1).ok());
  const auto events = service_->EventsSince(UserId{1}, 0, 100).value();
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().topic, "offer");
  EXPECT_TRUE(service_->EventsSince(UserId{1}, events.back().seq, 100).value().empty());
  EXPECT_TRUE(service_->EventsSince(UserId{2}, 0, 100).value().empty());
}

TEST_P(LabServiceTest, ACheckWhoseAnswerCouldNotBeStoredIsAskedForAgain) {
  std::atomic<bool> away{false};
  DatabaseOptions options = database_.options();
  options.at_commit = [&](CommitMoment moment) {
    if (away && moment == CommitMoment::kBefore) throw std::runtime_error("the cable is out");
  };
  service_.reset();
  bench_ = std::make_unique<WaitingBench>();
  const auto database = Database::Open(options).value();
  service_ = OpenService(*database, bench_);
  bench_->AwaitChecks(2);
  away = true;
  bench_->FailToPassChecks(*service_);
  away = false;
  ASSERT_TRUE(service_->TickNow().ok());
  bench_->AwaitChecks(2);
  bench_.PassChecks(*service_);
  EXPECT_EQ(service_->state()->rigs.at("bench-1").status, RigStatus::kReady);
  EXPECT_EQ(service_->state()->rigs.at("bench-2").status, RigStatus::kReady);
  service_.reset();
}

TEST_P(LabServiceTest, PracticeWhoseEndWasLostGivesItsSimulatorBack) {
  const auto begin = [&](Scheduler& lab, WallTime now) -> core::Result<Session> {
    if (!lab.state().rigs.contains("sim-1")) {
      (void)lab.AddRig("sim-1", "sim", true);
      (void)lab.Claim("sim-1", "local", now);
    }
    return lab.Practice(UserId{1}, {"sim-1"}, hours(1), now);
  };
  ASSERT_TRUE(service_->Do(begin).ok());
  bench_->SetRunning("sim-1");
  clock_.Advance(minutes(10));
  ASSERT_TRUE(service_->TickNow().ok());
  EXPECT_EQ(service_->state()->rigs.at("sim-1").status, RigStatus::kLeased) << "it runs";
  bench_->SetRunning("");
  ASSERT_TRUE(service_->TickNow().ok());
  EXPECT_EQ(service_->state()->rigs.at("sim-1").status, RigStatus::kReady);
  ASSERT_TRUE(service_->Do(begin).ok());
  clock_.Advance(seconds(20));
  ASSERT_TRUE(service_->TickNow().ok());
  EXPECT_EQ(service_->state()->rigs.at("sim-1").status, RigStatus::kLeased)
      << "its run may be about to begin";
}

TEST_P(LabServiceTest, ARunWhoseEndCouldNotBeStoredIsInterruptedWhenItsLeaseIsLongOver) {
  RecordingStore runs(*database_);
  const auto begin = [&](const std::string& id, const Session& session) {
    RunRecord run;
    run.id = id;
    run.rig = session.rig;
    run.epoch = session.epoch;
    run.server_id = "local";
    run.created_at = clock_.Wall();
    EXPECT_TRUE(runs.Begin(run).ok());
  };
  const Session over = Start(*service_, 1).value();
  const Session goes_on = Start(*service_, 2).value();
  begin("run-lost", over);
  begin("run-live", goes_on);
  ASSERT_TRUE(service_
                  ->Do([&](Scheduler& lab, WallTime now) {
                    return lab.EndSession(over.id, EndReason::kEnded, "", now);
                  })
                  .ok());
  const auto state_after = [&](seconds time) {
    for (seconds passed{0}; passed < time; passed += seconds(5)) {
      clock_.Advance(seconds(5));
      EXPECT_TRUE(service_->TickNow().ok());
    }
    return runs.Get("run-lost").value().state;
  };
  EXPECT_EQ(state_after(seconds(60)), RunState::kRunning) << "it may be at its last diagnosis";
  EXPECT_EQ(state_after(seconds(90)), RunState::kInterrupted);
  EXPECT_EQ(runs.Get("run-live").value().state, RunState::kRunning);
}

/// Lets time pass with a turn every minute.
void PassMinutes(LabService& service, ManualClock& clock, int count) {
  for (int i = 0; i < count; ++i) {
    clock.Advance(minutes(1));
    ASSERT_TRUE(service.TickNow().ok());
  }
}

TEST_P(LabServiceTest, AWallClockSetForwardAnHourLengthensNoLeaseAndCutsNone) {
  if (GetParam() == Engine::kPostgresql) return;  // there NTP keeps the clocks: see the code
  const Session session = Start(*service_, 1).value();
  clock_.JumpWall(hours(1));
  PassMinutes(*service_, clock_, 4);
  EXPECT_EQ(service_->state()->sessions.at(session.id).hard_end, session.hard_end)
      << "somebody may set it back";
  PassMinutes(*service_, clock_, 3);
  EXPECT_EQ(service_->state()->sessions.at(session.id).hard_end, session.hard_end + hours(1));
  EXPECT_EQ(service_->Now(), clock_.Wall());
  PassMinutes(*service_, clock_, 7);
  EXPECT_EQ(service_->state()->sessions.at(session.id).hard_end, session.hard_end + hours(1));
}

TEST_P(LabServiceTest, ABookingOutlivesAClockThatIsWrongForAWhile) {
  if (GetParam() == Engine::kPostgresql) return;
  const auto book = [&](int user, seconds in, seconds length) {
    return service_
        ->Do([&](Scheduler& lab, WallTime now) {
          return lab.Book(UserId{user}, "bench", {now + in, now + in + length}, now);
        })
        .value();
  };
  const Booking soon = book(1, minutes(30), minutes(20));
  for (const hours off : {hours(1), hours(-1)}) {
    clock_.JumpWall(off);
    PassMinutes(*service_, clock_, 3);
    clock_.JumpWall(-off);
    PassMinutes(*service_, clock_, 1);
    ASSERT_TRUE(service_->state()->bookings.contains(soon.id));
    EXPECT_EQ(service_->state()->bookings.at(soon.id).during, soon.during);
  }
  clock_.JumpWall(hours(1));  // and stays
  PassMinutes(*service_, clock_, 7);
  EXPECT_FALSE(service_->state()->bookings.contains(soon.id));
  const auto told = service_->EventsSince(UserId{1}, 0, 100).value();
  ASSERT_FALSE(told.empty());
  EXPECT_NE(told.back().text.find("clock"), std::string::npos) << told.back().text;
}

TEST_P(LabServiceTest, AChangedPolicyIsStoredAndReadByTheNextServer) {
  EXPECT_EQ(service_->policy().version, 0);
  const auto change = [&](LabService& service, std::int64_t version, Milliseconds grace) {
    return service.Do([&](Scheduler& lab, WallTime now) {
      PolicySettings settings = lab.policy();
      settings.version = version;
      settings.grace = grace;
      settings.week_max = hours(10);
      settings.live_bookings_max = 7;
      return lab.ChangePolicy(settings, now);
    });
  };
  ASSERT_TRUE(change(*service_, 0, minutes(5)).ok());
  ASSERT_TRUE(change(*service_, 1, minutes(6)).ok());
  EXPECT_EQ(service_->policy().grace, minutes(6));
  const Session session = Start(*service_, 1).value();
  PassMinutes(*service_, clock_, 28);
  const Session extended = service_->state()->sessions.at(session.id);
  ASSERT_GT(extended.extended, Milliseconds{0});
  Restart();
  service_ = OpenService(*database_, bench_);
  const Policy policy = service_->policy();
  EXPECT_EQ(policy.version, 2);
  EXPECT_EQ(policy.grace, minutes(6));
  EXPECT_EQ(policy.week_max, hours(10));
  EXPECT_EQ(policy.live_bookings_max, 7);
  EXPECT_EQ(policy.idle, PolicySettings{}.idle);
  EXPECT_EQ(service_->state()->sessions.at(session.id).extended, extended.extended);
}

INSTANTIATE_TEST_SUITE_P(Engines, LabServiceTest, tests::kBothEngines, tests::EngineName);

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
