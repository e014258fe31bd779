// Rigs of a class are interchangeable: an agent whose description differs from that of its class
// waits outside.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>

#include "hardware/bench/benches.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/server/app/shared_rigs.h"
#include "tests/support/await.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

const core::Bench& Servo() {
  return *hardware::LoadBench("servo-motor").value();
}

/// Agents of the class "desks" on a bus, each by its description; and this server's own rigs.
class ClassOfFarRigs : public testing::Test {
 protected:
  ~ClassOfFarRigs() override {
    if (shared_) shared_->Stop();
    rig_pool_.SetFinder({});
  }

  static std::shared_ptr<hardware::Rig> MakeRig(
      const std::string& id,
      const core::Bench& bench,
      hardware::RigKind kind = hardware::RigKind::kBench) {
    hardware::SimulatedRigOptions options;
    options.id = id;
    options.bench = &bench;
    options.rig_class = "desks";
    options.kind = kind;
    options.speed = 0.0;
    return hardware::MakeSimulatedRig(options);
  }
  void Hear(const std::string& id, const core::Bench& bench) {
    RigPool::Found found;
    const std::shared_ptr<hardware::Rig> rig = MakeRig(id, bench);
    found.status.description = rig->description();
    found.status.description.kind = hardware::RigKind::kRemote;
    found.status.remote.emplace().link = hardware::LinkState::kBack;
    found.make = [rig] { return rig; };
    const std::lock_guard lock(mutex_);
    heard_.push_back(std::move(found));
  }
  void Start() {
    rig_pool_.SetFinder([this] {
      const std::lock_guard lock(mutex_);
      return heard_;
    });
    shared_ = std::make_unique<tests::SharedRigs>(*database_, rig_pool_, clock_);
  }
  std::string ReasonOf(const std::string& rig) {
    const lab::Rig known = shared_->service().state()->rigs.at(rig);
    return std::string(Name(known.status)) + ": " + known.reason;
  }
  void AwaitReady(const std::string& rig) {
    EXPECT_TRUE(tests::Await([&] { return ReasonOf(rig) == "ready: "; }));
    EXPECT_EQ(ReasonOf(rig), "ready: ");
  }
  static std::string BuiltOtherwise(const core::Bench& bench) {
    return "offline: its class desks has rigs built otherwise (" + bench.id +
           "): give its description another rig_class, or update it";
  }

  tests::TestDatabase database_{Engine::kSqlite};
  SystemClock clock_;
  RigPool rig_pool_;
  std::mutex mutex_;
  std::vector<RigPool::Found> heard_;
  std::unique_ptr<tests::SharedRigs> shared_;
};

TEST_F(ClassOfFarRigs, IsBuiltLikeThisServersOwnRigs) {
  Hear("a-far", Servo());
  Hear("b-far", paper::Bench());
  rig_pool_.AddResident(MakeRig("own", paper::Bench()), "bench");
  Start();
  EXPECT_EQ(ReasonOf("a-far"), BuiltOtherwise(paper::Bench()));
  AwaitReady("own");
  AwaitReady("b-far");
  EXPECT_EQ(ReasonOf("a-far"), BuiltOtherwise(paper::Bench()));
}

TEST_F(ClassOfFarRigs, IsNotThatOfThisServersSimulators) {
  Hear("a-far", paper::Bench());
  rig_pool_.AddResident(MakeRig("own", paper::Bench(), hardware::RigKind::kSimulated), "sim");
  Start();
  AwaitReady("own");
  EXPECT_EQ(ReasonOf("a-far").find("offline: its class desks is that of this server's simulators"),
            0u)
      << ReasonOf("a-far");
  EXPECT_TRUE(shared_->service().state()->rigs.at("own").elastic);
}

TEST_F(ClassOfFarRigs, IsBuiltLikeTheFirstAgentWhenTheServerHasNoneOfItsOwn) {
  Hear("b-far", paper::Bench());
  Hear("a-far", Servo());
  Start();
  AwaitReady("a-far");
  EXPECT_EQ(ReasonOf("b-far"), BuiltOtherwise(Servo()));
}

TEST_F(ClassOfFarRigs, StaysAsItIsWhenAnAgentOfASmallerIdComes) {
  Hear("b-far", paper::Bench());
  Start();
  AwaitReady("b-far");
  Hear("a-far", Servo());
  EXPECT_TRUE(tests::Await([&] { return shared_->service().state()->rigs.contains("a-far"); }));
  EXPECT_EQ(ReasonOf("a-far"), BuiltOtherwise(paper::Bench()));
  EXPECT_EQ(ReasonOf("b-far"), "ready: ");
}

/// A rig of which this server hears nothing, while somebody has a session on it.
class SilentRig : public testing::Test {
 protected:
  ~SilentRig() override {
    if (shared_) shared_->Stop();
    if (rig_pool_) rig_pool_->SetFinder({});
  }
  /// Another server on the same database, with the rig "desk" or without.
  void Restart(bool with_desk) {
    if (shared_) shared_->Stop();
    shared_.reset();
    rig_pool_ = std::make_unique<RigPool>();
    if (with_desk) {
      rig_pool_->SetFinder([this] {
        RigPool::Found found;
        found.status.description = rig_->description();
        found.status.description.kind = hardware::RigKind::kRemote;
        const bool lost = is_lost_;
        found.status.remote.emplace().link =
            lost ? hardware::LinkState::kLost : hardware::LinkState::kBack;
        found.status.state = lost ? hardware::RigState::kOffline : hardware::RigState::kIdle;
        found.make = [this] { return rig_; };
        ++looks_;
        return std::vector<RigPool::Found>{std::move(found)};
      });
    }
    shared_ = std::make_unique<tests::SharedRigs>(*database_, *rig_pool_, clock_);
  }
  /// @param accepted  else it is only offered
  void GiveSession(bool accepted = true) {
    const std::uint64_t check = Desk().epoch;
    (void)shared_->service().CleaningDone("desk", check, true, "");  // its check is not the subject
    ASSERT_EQ(Desk().status, lab::RigStatus::kReady);
    const auto session = shared_->service().Do(
        [&](lab::Scheduler& scheduler, WallTime now) -> core::Result<lab::Session> {
          TRY(const auto ticket,
              scheduler.RequestTicket({.user = kUser, .rig_class = "desks", .job = ""}, now));
          if (!accepted) return lab::Session{};
          return scheduler.AcceptTicket(std::get<lab::Ticket>(ticket).id, kUser, now);
        });
    ASSERT_TRUE(session.ok()) << session.error().message;
  }
  void AwaitLooks() {
    const int looks = looks_;
    EXPECT_TRUE(tests::Await([&] { return looks_ >= looks + 2; }));
  }
  lab::Rig Desk() { return shared_->service().state()->rigs.at("desk"); }
  std::string AwaitOffline() {
    EXPECT_TRUE(tests::Await([&] { return Desk().status != lab::RigStatus::kLeased; }));
    EXPECT_EQ(Desk().status, lab::RigStatus::kOffline);
    return Desk().reason;
  }

  static constexpr lab::UserId kUser{1};
  tests::TestDatabase database_{Engine::kSqlite};
  ManualClock clock_;
  std::atomic<bool> is_lost_{false};
  std::atomic<int> looks_{0};
  std::shared_ptr<hardware::Rig> rig_ = [] {
    hardware::SimulatedRigOptions options;
    options.id = "desk";
    options.rig_class = "desks";
    options.kind = hardware::RigKind::kBench;
    return hardware::MakeSimulatedRig(options);
  }();
  std::unique_ptr<RigPool> rig_pool_;
  std::unique_ptr<tests::SharedRigs> shared_;
};

/// An agent is heard some seconds after a restart of the server, in which a session goes on.
TEST_F(SilentRig, IsWaitedForAfterARestartBeforeItsSessionEnds) {
  Restart(true);
  GiveSession();
  Restart(false);
  EXPECT_EQ(Desk().status, lab::RigStatus::kLeased);
  clock_.Advance(std::chrono::seconds(21));
  EXPECT_EQ(AwaitOffline(), "this server has no such rig now");
}

TEST_F(SilentRig, ThatIsOnlyOfferedGoesOfflineAtOnce) {
  Restart(true);
  GiveSession(/*accepted=*/false);
  EXPECT_EQ(Desk().status, lab::RigStatus::kLeased) << "held for who is offered it";
  is_lost_ = true;
  EXPECT_EQ(AwaitOffline(), "the rig does not answer");
}

TEST_F(SilentRig, ThatIsHeardAgainSoonKeepsItsSession) {
  Restart(true);
  GiveSession();
  const std::uint64_t epoch = Desk().epoch;
  for (int i = 0; i < 3; ++i) {  // each silence is a new one
    is_lost_ = true;
    AwaitLooks();
    clock_.Advance(std::chrono::seconds(15));
    AwaitLooks();
    EXPECT_EQ(Desk().status, lab::RigStatus::kLeased);
    is_lost_ = false;
    AwaitLooks();
  }
  EXPECT_EQ(Desk().epoch, epoch);
  is_lost_ = true;
  AwaitLooks();
  clock_.Advance(std::chrono::seconds(21));
  EXPECT_EQ(AwaitOffline(), "the rig does not answer");
}

}  // namespace
}  // namespace faultlab::server
