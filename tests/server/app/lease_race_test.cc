// Leases of a rig, without HTTP: before the scheduler knows the rig, and in races for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <random>
#include <stdexcept>
#include <thread>

#include "hardware/simulated/simulated_rig.h"
#include "server/run/run_manager.h"
#include "tests/paper_rig.h"
#include "tests/server/app/shared_rigs.h"
#include "tests/support/await.h"
#include "tests/support/scale.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;
using tests::Await;

class SharedRigsTest : public testing::Test {
 protected:
  SharedRigsTest() : database_(Engine::kSqlite) {
    shared_ = std::make_unique<tests::SharedRigs>(*database_, rig_pool_, clock_);
  }
  ~SharedRigsTest() override { shared_->Stop(); }

  void AddRig(const std::string& id, hardware::RigKind kind) {
    hardware::SimulatedRigOptions options;
    options.id = id;
    options.kind = kind;
    rig_pool_.AddResident(hardware::MakeSimulatedRig(options), "bench");
  }
  core::Result<RigHandle> Hold(const Principal& who,
                               const std::string& rig,
                               std::chrono::milliseconds length) {
    return shared_->access().Hold(who, StartedBy::kPerson, rig, paper::Bench(), length);
  }
  core::Status GuestMayUse(const std::string& rig) {
    const auto hold = Hold(Principal{}, rig, std::chrono::seconds(1));
    return hold.ok() ? core::Status(core::Done{}) : core::Status(hold.error());
  }

  tests::TestDatabase database_;
  SystemClock clock_;
  RecordingStore store_{*database_};
  RigPool rig_pool_;
  StreamHub hub_{{}, clock_};
  RunManager runs_{{}, store_, hub_, clock_, [](std::string_view) {}};
  std::unique_ptr<tests::SharedRigs> shared_;
};

TEST_F(SharedRigsTest, LetsNobodyUseABenchInTheMomentInWhichItIsFound) {
  for (const auto kind : {hardware::RigKind::kBench, hardware::RigKind::kRemote}) {
    const std::string id = "found-" + std::string(hardware::Name(kind));
    AddRig(id, kind);
    const core::Status asked = GuestMayUse(id);
    ASSERT_FALSE(asked.ok()) << id;
    EXPECT_TRUE(asked.error().code == ErrorCode::kUnavailable ||
                asked.error().code == ErrorCode::kForbidden)
        << asked.error().message;
  }
}

TEST_F(SharedRigsTest, ChecksItsRigsSideBySide) {
  AddRig("first", hardware::RigKind::kBench);
  AddRig("second", hardware::RigKind::kBench);
  EXPECT_TRUE(tests::Await([&] {
    return std::ranges::count(rig_pool_.List(), hardware::RigState::kRunning, &RigStatus::state) ==
           2;
  })) << "one check waits for the other";
}

/// A rig on the bus after a restart: its check is due before its agent's messages arrive.
TEST_F(SharedRigsTest, ARigThatIsNotHeardYetHasNotFailedItsCheck) {
  const core::Status claimed =
      shared_->service().Do([](lab::Scheduler& scheduler, WallTime now) -> core::Status {
        const core::Status added = scheduler.AddRig("far-1", "bench-sim", false);
        return added.ok() ? scheduler.Claim("far-1", "local", now) : added;
      });
  ASSERT_TRUE(claimed.ok());
  const auto rig = [&] { return shared_->service().state()->rigs.at("far-1"); };
  ASSERT_TRUE(Await([&] { return rig().status != lab::RigStatus::kCleaning; }));
  EXPECT_EQ(rig().status, lab::RigStatus::kOffline) << rig().reason;
}

/// A person has a session on the bench, which ends or is handed over while the person starts a run.
/// In any order, no run of the older epoch is left when the end has been announced.
class LeaseRace : public SharedRigsTest {
 protected:
  LeaseRace() {
    // Built anew for each lease, which takes a moment, as with a rig that answers over a network.
    hardware::SimulatedRigOptions options;
    options.id = "bench-1";
    options.kind = hardware::RigKind::kBench;
    rig_pool_.Add(hardware::MakeSimulatedRig(options)->description(), "bench", [this, options] {
      const auto until = std::chrono::steady_clock::now() + making_.load();
      while (std::chrono::steady_clock::now() < until) std::this_thread::yield();
      return std::shared_ptr<hardware::Rig>(hardware::MakeSimulatedRig(options));
    });
    if (!Await([this] { return Status() == lab::RigStatus::kReady; }))
      throw std::runtime_error("the rig is not ready");
  }
  lab::RigStatus Status() {
    const auto state = shared_->service().state();
    const auto rig = state->rigs.find("bench-1");
    return rig == state->rigs.end() ? lab::RigStatus::kOffline : rig->second.status;
  }
  static Principal Person(std::int64_t id) {
    Principal who;
    who.user_id = id;
    who.role = Role::kStudent;
    who.proof = Proof::kSessionCookie;
    return who;
  }
  lab::Session SessionOf(std::int64_t user) {
    lab::TicketRequest wanted;
    wanted.user = lab::UserId{user};
    wanted.rig_class = "bench-sim";
    const auto given = shared_->service().Do(
        [&](lab::Scheduler& scheduler, WallTime now) -> core::Result<lab::Session> {
          const auto ticket = scheduler.RequestTicket(wanted, now);
          if (!ticket) return ticket.error();
          return scheduler.AcceptTicket(std::get<lab::Ticket>(ticket.value()).id, wanted.user, now);
        });
    EXPECT_TRUE(given.ok()) << given.error().message;
    return given.value();
  }
  /// A complete POST /runs except for HTTP.
  void StartRun(const Principal& who) {
    auto hold = Hold(who, "bench-1", std::chrono::seconds(60));
    if (!hold) return;
    RunRequest request;
    request.diagnosis = paper::Options();
    request.plan.uc_v.assign(1000, 2.0);
    request.hold = std::move(hold).value();
    (void)runs_.Start(std::move(request));
  }
  int RunsBelow(std::uint64_t epoch) {
    int count = 0;
    for (const RunSnapshot& run : runs_.Running()) {
      // The second change would wait for the end of the calibration, so the rig does not check it.
      const hardware::RigCommand change{
          hardware::RigCommand::Kind::kSetComponent, paper::kR1, 100.0};
      const bool commands = runs_.Command(run.id, run.epoch, {}).ok() ||
                            runs_.Command(run.id, run.epoch, change).ok();
      if (commands && static_cast<std::uint64_t>(run.epoch) < epoch) ++count;
    }
    return count;
  }

  std::atomic<std::chrono::microseconds> making_{};
};

/// The number of rounds of each race, and the seed, by hand.
std::uint64_t FromEnvironment(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
}

enum class Change { kEnd, kHandOver, kTakeOver };

class LeaseRaces : public LeaseRace, public testing::WithParamInterface<Change> {
 protected:
  /// Varies the schedule of one thread: other work for a random time, with or without yielding the
  /// processor.
  void Dawdle(std::mt19937_64& chance) {
    const auto moment = std::chrono::microseconds(chance() % kSpread.count());
    const bool yields = chance() % 2 == 0;
    const auto until = std::chrono::steady_clock::now() + moment;
    while (std::chrono::steady_clock::now() < until) {
      if (yields) std::this_thread::yield();
    }
  }
  core::Status Make(Change change, lab::SessionId session) {
    return shared_->service().Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
      if (change == Change::kEnd) {
        return scheduler.EndSession(session, lab::EndReason::kEnded, "", now);
      }
      const auto given = change == Change::kTakeOver
                             ? scheduler.TakeOver(session, kHeir, "race", now)
                             : scheduler.AcceptControl(session, kHeir, now);
      return given.ok() ? core::Status(core::Done{}) : core::Status(given.error());
    });
  }
  /// A run that was not stopped plays its plan to the end.
  void ExpectStopped(std::uint64_t epoch) {
    for (const RunSnapshot& run : runs_.Running()) {
      if (static_cast<std::uint64_t>(run.epoch) != epoch) continue;
      runs_.Wait(run.id);
      EXPECT_NE(store_.Get(run.id).value().state, RunState::kFinished) << "it drove on";
    }
  }
  /// The check between users is not the subject here.
  void PassCheck() {
    const std::uint64_t check = shared_->service().state()->rigs.at("bench-1").epoch;
    (void)shared_->service().CleaningDone("bench-1", check, true, "");
    ASSERT_EQ(Status(), lab::RigStatus::kReady);
  }

  static constexpr lab::UserId kHeir{2};
  static constexpr std::chrono::microseconds kSpread{3000};  ///< about the time of a start
};

TEST_P(LeaseRaces, LeaveNoRunOfTheOlderEpochAndLetTheHeirIn) {
  const std::uint64_t rounds = FromEnvironment("FAULTLAB_RACE_ROUNDS", tests::Proving() ? 70 : 20);
  std::mt19937_64 chance(FromEnvironment("FAULTLAB_RACE_SEED", 1));
  for (std::uint64_t round = 0; round < rounds && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const lab::Session session = SessionOf(1);
    if (GetParam() == Change::kHandOver) {
      ASSERT_TRUE(shared_->service()
                      .Do([&](lab::Scheduler& scheduler, WallTime now) {
                        return scheduler.OfferControl(session.id, kHeir, now);
                      })
                      .ok());
    }
    std::mt19937_64 of_starter(chance());
    making_ = std::chrono::microseconds(chance() % 1000);
    std::atomic<bool> go{false};
    std::thread starter([&] {
      while (!go) std::this_thread::yield();
      Dawdle(of_starter);
      StartRun(Person(1));
    });
    go = true;
    const bool runs_before = chance() % 4 == 0;  // otherwise the two race
    if (runs_before) starter.join();
    Dawdle(chance);
    const core::Status changed = Make(GetParam(), session.id);
    // The change is announced: from now on nothing of the old epoch may drive or start to drive.
    EXPECT_EQ(RunsBelow(session.epoch + 1), 0);
    if (!runs_before) starter.join();
    ASSERT_TRUE(changed.ok()) << changed.error().message;
    EXPECT_EQ(RunsBelow(session.epoch + 1), 0);
    ExpectStopped(session.epoch);
    if (GetParam() != Change::kEnd) {
      EXPECT_TRUE(Hold(Person(2), "bench-1", std::chrono::seconds(1)).ok())
          << "the new holder has the rig at once";
      ASSERT_TRUE(Make(Change::kEnd, session.id).ok());
    }
    PassCheck();
  }
}

INSTANTIATE_TEST_SUITE_P(Changes,
                         LeaseRaces,
                         testing::Values(Change::kEnd, Change::kHandOver, Change::kTakeOver),
                         [](const auto& change) {
                           if (change.param == Change::kEnd) return "End";
                           return change.param == Change::kHandOver ? "HandOver" : "TakeOver";
                         });

TEST_F(SharedRigsTest, LetsEverybodyUseASimulatorAndNobodyANameThatIsNoRig) {
  AddRig("sim-1", hardware::RigKind::kSimulated);
  while (!shared_->service().state()->rigs.contains("sim-1")) std::this_thread::yield();
  EXPECT_TRUE(GuestMayUse("sim-1").ok());
  EXPECT_TRUE(GuestMayUse("").ok());
  ASSERT_FALSE(GuestMayUse("nowhere").ok());
  EXPECT_EQ(GuestMayUse("nowhere").error().code, ErrorCode::kNotFound);
}

/// The lease of a practice may end before its run has let go of the simulator, as at a stop.
TEST_F(SharedRigsTest, PracticeTakesASimulatorThatNobodyHolds) {
  AddRig("sim-1", hardware::RigKind::kSimulated);
  AddRig("sim-2", hardware::RigKind::kSimulated);
  while (shared_->service().state()->rigs.size() < 2) std::this_thread::yield();
  Principal one;
  one.user_id = 1;
  Principal two;
  two.user_id = 2;
  const auto first = Hold(one, "", std::chrono::seconds(1));
  ASSERT_TRUE(first.ok()) << first.error().message;
  const auto ended = shared_->service().Do([&](lab::Scheduler& scheduler, WallTime now) {
    scheduler.EndPractice(first.value().lease().session, now);
    return core::Status(core::Done{});
  });
  ASSERT_TRUE(ended.ok());
  const auto second = Hold(two, "", std::chrono::seconds(1));
  ASSERT_TRUE(second.ok()) << second.error().message;
  EXPECT_NE(second.value().lease().rig, first.value().lease().rig);
}

}  // namespace
}  // namespace faultlab::server
