// Who has a rig, without HTTP: before the scheduler knows it, and in races for it.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "hardware/simulated/simulated_rig.h"
#include "server/run/run_manager.h"
#include "tests/server/app/shared_rigs.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;

class SharedRigsTest : public testing::Test {
 protected:
  SharedRigsTest() : database_(Engine::kSqlite) {
    shared_ = std::make_unique<tests::SharedRigs>(*database_, bay_, clock_);
  }
  ~SharedRigsTest() override { shared_->Stop(); }

  void AddRig(const std::string& id, hardware::RigKind kind) {
    hardware::SimulatedRigOptions options;
    options.id = id;
    options.kind = kind;
    bay_.AddResident(hardware::MakeSimulatedRig(options), "bench");
  }
  core::Result<RigHold> Hold(const Principal& who,
                             const std::string& rig,
                             std::chrono::milliseconds length) {
    return shared_->access().Hold(who, StartedBy::kPerson, rig, length);
  }
  core::Status GuestMayUse(const std::string& rig) {
    const auto hold = Hold(Principal{}, rig, std::chrono::seconds(1));
    return hold.ok() ? core::Status(core::Done{}) : core::Status(hold.error());
  }

  tests::TestDatabase database_;
  SystemClock clock_;
  RecordingStore store_{*database_};
  RigBay bay_;
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

/// A person with a session on the bench, whose session ends or is handed over while they start a
/// run: whatever the order, no run of the older epoch is left when the end has been told.
class LeaseRace : public SharedRigsTest {
 protected:
  LeaseRace() {
    AddRig("bench-1", hardware::RigKind::kBench);
    while (Status() != lab::RigStatus::kReady) std::this_thread::yield();
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
  /// A whole POST /runs but for HTTP.
  void StartRun(const Principal& who) {
    auto hold = Hold(who, "bench-1", std::chrono::seconds(60));
    if (!hold) return;
    RunRequest request;
    request.plan.uc_v.assign(6000, 2.0);
    request.hold = std::move(hold).value();
    (void)runs_.Start(std::move(request));
  }
  int RunsBelow(std::uint64_t epoch) {
    int count = 0;
    for (const RunSnapshot& run : runs_.Running()) {
      const bool commands = runs_.Command(run.id, run.epoch, {}).ok();
      if (commands && static_cast<std::uint64_t>(run.epoch) < epoch) ++count;
    }
    return count;
  }
};

TEST_F(LeaseRace, NoRunOutlivesItsSession) {
  constexpr int kRounds = 200;
  for (int round = 0; round < kRounds; ++round) {
    const lab::Session session = SessionOf(1);
    std::atomic<bool> go{false};
    std::thread starter([&] {
      while (!go) std::this_thread::yield();
      for (int i = 0; i < round % 7 * 100; ++i) std::atomic_signal_fence(std::memory_order_seq_cst);
      StartRun(Person(1));
    });
    go = true;
    const bool runs_before = round % 4 >= 2;  // else the two race
    if (runs_before) starter.join();
    for (int i = 0; i < round % 11 * 300; ++i) std::atomic_signal_fence(std::memory_order_seq_cst);
    const bool hands_over = round % 2 == 1;
    const auto ended = shared_->service().Do([&](lab::Scheduler& scheduler,
                                                 WallTime now) -> core::Result<lab::Session> {
      if (hands_over) return scheduler.TakeOver(session.id, lab::UserId{2}, "race", now);
      const core::Status done = scheduler.EndSession(session.id, lab::EndReason::kEnded, "", now);
      if (!done.ok()) return done.error();
      return session;
    });
    ASSERT_TRUE(ended.ok());
    // The end is told: from now on nothing of the old epoch may drive or start to.
    EXPECT_EQ(RunsBelow(session.epoch + 1), 0) << "round " << round;
    if (!runs_before) starter.join();
    EXPECT_EQ(RunsBelow(session.epoch + 1), 0) << "round " << round;
    if (hands_over) {
      EXPECT_TRUE(Hold(Person(2), "bench-1", std::chrono::seconds(1)).ok())
          << "the new holder has the rig at once";
      ASSERT_TRUE(shared_->service()
                      .Do([&](lab::Scheduler& scheduler, WallTime now) {
                        return scheduler.EndSession(session.id, lab::EndReason::kEnded, "", now);
                      })
                      .ok());
    }
    // The check between users is not what this is about.
    const std::uint64_t check = shared_->service().state()->rigs.at("bench-1").epoch;
    (void)shared_->service().CleaningDone("bench-1", check, true, "");
    ASSERT_EQ(Status(), lab::RigStatus::kReady) << round;
  }
}

TEST_F(SharedRigsTest, LetsEverybodyUseASimulatorAndNobodyANameThatIsNoRig) {
  AddRig("sim-1", hardware::RigKind::kSimulated);
  while (!shared_->service().state()->rigs.contains("sim-1")) std::this_thread::yield();
  EXPECT_TRUE(GuestMayUse("sim-1").ok());
  EXPECT_TRUE(GuestMayUse("").ok());
  ASSERT_FALSE(GuestMayUse("nowhere").ok());
  EXPECT_EQ(GuestMayUse("nowhere").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace faultlab::server
