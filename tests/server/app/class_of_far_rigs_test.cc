// Rigs of a class are interchangeable: an agent whose description differs from that of its class
// waits outside.
#include <gtest/gtest.h>

#include <chrono>
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

  static std::shared_ptr<hardware::Rig> MakeRig(const std::string& id, const core::Bench& bench) {
    hardware::SimulatedRigOptions options;
    options.id = id;
    options.bench = &bench;
    options.rig_class = "desks";
    options.kind = hardware::RigKind::kBench;
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

/// An agent is heard some seconds after a restart of the server, in which a session goes on.
TEST(RigsOfBefore, AreWaitedForBeforeTheirSessionsEnd) {
  tests::TestDatabase database(Engine::kSqlite);
  ManualClock clock;
  constexpr lab::UserId kUser{1};
  {
    RigPool rig_pool;
    hardware::SimulatedRigOptions options;
    options.id = "desk";
    options.rig_class = "desks";
    options.kind = hardware::RigKind::kBench;
    rig_pool.AddResident(hardware::MakeSimulatedRig(options), "bench");
    tests::SharedRigs before(*database, rig_pool, clock);
    const std::uint64_t check = before.service().state()->rigs.at("desk").epoch;
    (void)before.service().CleaningDone("desk", check, true, "");  // its check is not the subject
    ASSERT_EQ(before.service().state()->rigs.at("desk").status, lab::RigStatus::kReady);
    const auto session = before.service().Do(
        [&](lab::Scheduler& scheduler, WallTime now) -> core::Result<lab::Session> {
          const auto ticket =
              scheduler.RequestTicket({.user = kUser, .rig_class = "desks", .job = ""}, now);
          if (!ticket) return ticket.error();
          return scheduler.AcceptTicket(std::get<lab::Ticket>(ticket.value()).id, kUser, now);
        });
    ASSERT_TRUE(session.ok()) << session.error().message;
    before.Stop();
  }
  RigPool empty;
  tests::SharedRigs after(*database, empty, clock);
  const auto desk = [&] { return after.service().state()->rigs.at("desk"); };
  EXPECT_EQ(desk().status, lab::RigStatus::kLeased);
  clock.Advance(std::chrono::seconds(6));
  EXPECT_TRUE(tests::Await([&] { return desk().status != lab::RigStatus::kLeased; }));
  EXPECT_EQ(desk().status, lab::RigStatus::kOffline);
  EXPECT_EQ(desk().reason, "this server has no such rig now");
  after.Stop();
}

}  // namespace
}  // namespace faultlab::server
