// The lab with a real agent on a bus: which lab has the rig, and what people are told when it is
// another one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <thread>

#include "tests/hardware/remote_world.h"
#include "tests/server/app/shared_rigs.h"
#include "tests/support/await.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using hardware::AgentThread;
using hardware::Epoch;
using hardware::EpochFile;
using hardware::LossyBus;
using hardware::ServerThread;
using hardware::StateFolder;
using testing::HasSubstr;
using testing::Not;

constexpr double kSpeed = 5.0;

hardware::RigAgentSettings Patient() {
  hardware::RigAgentSettings settings;
  settings.watchdog = std::chrono::seconds(20);
  settings.lease = std::chrono::seconds(25);
  return settings;
}

/// A server of lab "here" that finds the rig "far-1" on a bus.
class FarRigTest : public testing::Test {
 protected:
  ~FarRigTest() override {
    if (shared_) shared_->Stop();
    rig_pool_.SetFinder({});
  }

  /// @param epoch  epoch that the rig has had in this lab
  void StartServer(std::uint64_t epoch = 0) {
    shared_ = std::make_unique<tests::SharedRigs>(*database_, rig_pool_, clock_);
    const core::Status known =
        shared_->service().Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
          for (std::uint64_t i = 0; i < epoch; ++i) {
            core::Status done = scheduler.AddRig("far-1", "bench-sim", false);
            if (done.ok()) done = scheduler.Claim("far-1", "local", now);
            if (done.ok()) done = scheduler.RigOffline("far-1", "not seen yet", now);
            if (!done.ok()) return done;
          }
          return core::Done{};
        });
    ASSERT_TRUE(known.ok());
    here_.WaitUntilHeard();
    rig_pool_.SetFinder([this] {
      ++looks_;
      RigStatus status;
      status.remote = here_.rig().info();
      status.description = status.remote->description;
      status.state = status.remote->link == hardware::LinkState::kLost
                         ? hardware::RigState::kOffline
                         : status.remote->state;
      return std::vector<RigPool::Found>{
          {std::move(status), [this] { return here_.shared_rig(); }}};
    });
  }

  lab::Rig Rig() {
    const auto state = shared_->service().state();
    const auto rig = state->rigs.find("far-1");
    return rig == state->rigs.end() ? lab::Rig{} : rig->second;
  }
  /// Waits for the status. @returns the statuses of the rig until then
  std::set<lab::RigStatus> Await(lab::RigStatus wanted, const std::string& reason = "") {
    std::set<lab::RigStatus> seen;
    EXPECT_TRUE(tests::Await([&] {
      const lab::Rig rig = Rig();
      if (rig.status == wanted && rig.reason.find(reason) != std::string::npos) return true;
      if (!rig.id.empty()) seen.insert(rig.status);
      return false;
    })) << "the rig is "
        << Name(Rig().status) << ": " << Rig().reason;
    return seen;
  }
  core::Status Adopt(const std::string& rig) {
    TRY(const auto found, rig_pool_.Find(rig));
    TRY(const auto seen, EpochSeenBy(found));
    return shared_->service().Do([&](lab::Scheduler& lab, WallTime now) -> core::Status {
      return lab.Adopt(rig, seen, now);
    });
  }

  LossyBus bus_{{}, 1};
  const StateFolder state_;
  std::atomic<int> looks_{0};  ///< number of searches on the bus
  ServerThread here_{bus_, kSpeed, "here/a"};

  tests::TestDatabase database_{Engine::kSqlite};
  ManualClock clock_;
  RigPool rig_pool_;
  std::unique_ptr<tests::SharedRigs> shared_;
};

TEST_F(FarRigTest, IsLeasedWithTheEpochOfTheLabFromTheCheckOn) {
  AgentThread agent(bus_, kSpeed, Patient(), "far-1", &state_);
  StartServer();
  (void)Await(lab::RigStatus::kReady);
  EXPECT_EQ(state_.Open().seen(), (hardware::SeenLease{Rig().epoch, "here/a"}));
}

TEST_F(FarRigTest, ThatHasSeenMoreThanTheDatabaseSaysSoAndIsAdopted) {
  ASSERT_TRUE(state_.Open().Raise({500, "here/before-the-restore"}).ok());
  AgentThread agent(bus_, kSpeed, Patient(), "far-1", &state_);
  StartServer();
  (void)Await(lab::RigStatus::kQuarantined);
  EXPECT_THAT(Rig().reason, HasSubstr("the rig has seen epoch 500 of here/before-the-restore"));
  EXPECT_THAT(Rig().reason, HasSubstr("this lease is of epoch " + std::to_string(Rig().epoch)));
  EXPECT_THAT(Rig().reason, HasSubstr("adopt the rig"));
  EXPECT_THAT(Rig().reason, Not(HasSubstr("relays")));
  EXPECT_EQ(agent.rig().state(), hardware::RigState::kIdle);

  const auto adopted = Adopt("far-1");
  ASSERT_TRUE(adopted.ok()) << adopted.error().message;
  (void)Await(lab::RigStatus::kReady);
  EXPECT_GT(Rig().epoch, 500u);
  EXPECT_EQ(state_.Open().seen().epoch, Rig().epoch);
  EXPECT_EQ(Adopt("far-1").error().code, core::ErrorCode::kConflict) << "it is in order";
  EXPECT_EQ(Adopt("nowhere").error().code, core::ErrorCode::kNotFound);
}

TEST_F(FarRigTest, ThatAnotherLabHoldsIsWaitedForAndNeverQuarantined) {
  AgentThread agent(bus_, kSpeed, Patient(), "far-1", &state_);
  auto there = std::make_unique<ServerThread>(bus_, kSpeed, "there/b");
  there->WaitUntilHeard();
  ASSERT_TRUE(there->rig().SelfTest(Epoch{1}).ok());
  StartServer(/*epoch=*/7);
  std::set<lab::RigStatus> was = Await(lab::RigStatus::kOffline, "the rig is held by there/b");
  const std::uint64_t epoch = Rig().epoch;
  EXPECT_EQ(Adopt("far-1").error().code, core::ErrorCode::kConflict);
  Principal student;
  student.user_id = 5;
  const auto asked = shared_->access().Hold(
      student, StartedBy::kPerson, "far-1", paper::Bench(), std::chrono::seconds(1));
  ASSERT_FALSE(asked.ok());
  EXPECT_EQ(asked.error().reason, "held_elsewhere");
  EXPECT_THAT(asked.error().message, HasSubstr("the rig is held by there/b"));
  const int looks = looks_;
  while (looks_ < looks + 3) {
    clock_.Advance(std::chrono::seconds(1));
    ASSERT_TRUE(there->rig().SelfTest(Epoch{1}).ok()) << "still theirs";
  }
  EXPECT_EQ(Rig().status, lab::RigStatus::kOffline);
  EXPECT_EQ(Rig().epoch, epoch) << "nothing was tried";
  there.reset();  // gives the rig back
  clock_.Advance(shared_->service().policy().check_pause);
  was.merge(Await(lab::RigStatus::kReady));
  EXPECT_FALSE(was.contains(lab::RigStatus::kQuarantined));
}

TEST_F(FarRigTest, ThatCannotKeepItsEpochWaitsUntilItCanAndSaysWhy) {
  const std::string blocked = state_.path() + "/far-1.epoch.new";
  std::filesystem::create_directories(blocked);  // where the agent writes
  AgentThread agent(bus_, kSpeed, Patient(), "far-1", &state_);
  StartServer();
  const auto was = Await(lab::RigStatus::kOffline, "the agent cannot keep the rig's epoch");
  EXPECT_FALSE(was.contains(lab::RigStatus::kQuarantined));
  std::filesystem::remove(blocked);
  clock_.Advance(shared_->service().policy().check_pause);
  (void)Await(lab::RigStatus::kReady);
}

}  // namespace
}  // namespace faultlab::server
