#include "server/run/rig_pool.h"

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <thread>

#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/rig_runs.h"
#include "tests/paper_bench.h"
#include "tests/server/run/fake_rig.h"

namespace faultlab::server {
namespace {

using tests::FakeRig;
using namespace std::chrono_literals;

hardware::RigDescription Simulated(const std::string& id) {
  hardware::RigDescription description;
  description.bench = &paper::Bench();
  description.id = id;
  description.kind = hardware::RigKind::kSimulated;
  return description;
}

lab::Lease LeaseOn(const std::string& rig, std::uint64_t epoch) {
  return {.rig = rig, .session = {}, .epoch = epoch, .holder = {}, .until = {}};
}

class RigPoolTest : public ::testing::Test {
 protected:
  RigPoolTest() {
    for (const char* id : {"sim-1", "sim-2"}) {
      rig_pool_.Add(Simulated(id), "bench", [this, id] {
        if (while_it_is_made_) while_it_is_made_();
        last_ = std::make_shared<FakeRig>(id);
        return last_;
      });
    }
  }
  RigPool rig_pool_;
  std::function<void()> while_it_is_made_;
  std::shared_ptr<FakeRig> last_;
};

TEST_F(RigPoolTest, PutsTheRigIntoTheHandsOfTheLeaseAndItsEpoch) {
  const auto hold = rig_pool_.Acquire(LeaseOn("sim-2", 7));
  ASSERT_TRUE(hold.ok());
  EXPECT_EQ(hold.value().rig().description().id, "sim-2");
  EXPECT_EQ(hold.value().epoch(), hardware::Epoch{7});
  EXPECT_TRUE(rig_pool_.Holds("sim-2"));
  EXPECT_FALSE(rig_pool_.Holds("sim-1"));
  EXPECT_EQ(rig_pool_.List()[1].epoch, hardware::Epoch{7});
  EXPECT_EQ(rig_pool_.Acquire(LeaseOn("sim-2", 7), 0ms).error().code, core::ErrorCode::kBusy)
      << "a lease has its rig once";
}

TEST_F(RigPoolTest, RefusesALeaseBelowItsFence) {
  rig_pool_.Fence("sim-1", 5);
  EXPECT_EQ(rig_pool_.Acquire(LeaseOn("sim-1", 4)).error().code, core::ErrorCode::kStale);
  EXPECT_TRUE(rig_pool_.Acquire(LeaseOn("sim-1", 5)).ok());
  EXPECT_EQ(rig_pool_.Acquire(LeaseOn("sim-1", 4)).error().code, core::ErrorCode::kStale);
}

TEST_F(RigPoolTest, AFenceStopsTheHolderAndItsRigRefusesTheEpoch) {
  const auto hold = rig_pool_.Acquire(LeaseOn("sim-1", 4));
  ASSERT_TRUE(hold.ok());
  EXPECT_FALSE(hold.value().revoked());
  rig_pool_.Fence("sim-1", 4);
  EXPECT_FALSE(hold.value().revoked()) << "its own epoch";
  rig_pool_.Fence("sim-1", 5);
  EXPECT_TRUE(hold.value().revoked());
  EXPECT_EQ(last_->fence(), hardware::Epoch{5});
}

TEST_F(RigPoolTest, AFenceThatComesWhileTheRigIsMadeIsNotMissed) {
  while_it_is_made_ = [this] { rig_pool_.Fence("sim-1", 5); };
  EXPECT_EQ(rig_pool_.Acquire(LeaseOn("sim-1", 4)).error().code, core::ErrorCode::kStale);
  EXPECT_FALSE(rig_pool_.Holds("sim-1"));
}

TEST_F(RigPoolTest, ANewerLeaseStopsTheOlderHolderAndWaitsForIt) {
  auto old = rig_pool_.Acquire(LeaseOn("sim-1", 4));
  ASSERT_TRUE(old.ok());
  std::thread run([&] {
    while (!old.value().revoked()) std::this_thread::yield();
    old.value().Release();
  });
  const auto next = rig_pool_.Acquire(LeaseOn("sim-1", 5), 20s);
  run.join();
  ASSERT_TRUE(next.ok()) << next.error().message;
  EXPECT_EQ(next.value().epoch(), hardware::Epoch{5});
}

TEST_F(RigPoolTest, ANewerLeaseThatWaitsInVainIsTold) {
  const auto old = rig_pool_.Acquire(LeaseOn("sim-1", 4));
  EXPECT_EQ(rig_pool_.Acquire(LeaseOn("sim-1", 5), 1ms).error().code, core::ErrorCode::kBusy);
}

TEST_F(RigPoolTest, TellsWhoseHoldHasEnded) {
  std::vector<std::uint64_t> ended;
  rig_pool_.OnRelease([&](const lab::Lease& lease) {
    EXPECT_FALSE(rig_pool_.Holds(lease.rig)) << "the rig is free by then";
    ended.push_back(lease.epoch);
  });
  { const auto hold = rig_pool_.Acquire(LeaseOn("sim-1", 4)); }
  EXPECT_EQ(ended, std::vector<std::uint64_t>{4});
}

TEST_F(RigPoolTest, HasEveryRigThatTurnsUpHoweverManyThereAre) {
  int count = 0;
  rig_pool_.SetFinder([&] {
    std::vector<RigPool::Found> found;
    for (int i = 0; i < count; ++i) {
      const std::string id = "far-" + std::to_string(i);
      RigStatus status;
      status.description = Simulated(id);
      status.description.kind = hardware::RigKind::kRemote;
      status.remote.emplace();
      found.push_back({std::move(status), [id] { return std::make_shared<FakeRig>(id); }});
    }
    return found;
  });
  for (count = 1; count <= 20; ++count) {
    EXPECT_EQ(rig_pool_.List().size(), static_cast<std::size_t>(2 + count));
    const std::string id = "far-" + std::to_string(count - 1);
    const auto hold = rig_pool_.Acquire(LeaseOn(id, 1));
    ASSERT_TRUE(hold.ok()) << hold.error().message;
    EXPECT_EQ(hold.value().rig().description().id, id);
  }
}

TEST_F(RigPoolTest, WhatOnlyAFarRigIsBuiltLikeIsKnown) {
  core::Bench other = paper::Bench();
  other.id = "other";
  using enum RigPool::Like;
  EXPECT_EQ(rig_pool_.FindLike(other, kAnyRig).error().code, core::ErrorCode::kNotFound);
  rig_pool_.SetFinder([&other] {
    RigStatus status;
    status.description = Simulated("far-1");
    status.description.kind = hardware::RigKind::kRemote;
    status.description.bench = &other;
    status.remote.emplace();
    std::vector<RigPool::Found> found;
    found.push_back({std::move(status), [] { return std::make_shared<FakeRig>("far-1"); }});
    return found;
  });
  EXPECT_EQ(rig_pool_.FindLike(other, kAnyRig).value().description.id, "far-1");
  EXPECT_EQ(rig_pool_.FindLike(other, kSimulator).error().code, core::ErrorCode::kNotFound);
  EXPECT_EQ(rig_pool_.FindLike(paper::Bench(), kAnyRig).value().description.id, "sim-1");
}

TEST_F(RigPoolTest, ANameOnTheBusMakesNoLocalRigAFarOne) {
  rig_pool_.SetFinder([] {
    RigStatus status;
    status.description = Simulated("sim-1");
    status.description.kind = hardware::RigKind::kRemote;
    status.remote.emplace();
    std::vector<RigPool::Found> found;
    found.push_back({std::move(status), [] { return std::make_shared<FakeRig>("forged"); }});
    return found;
  });
  EXPECT_EQ(rig_pool_.Find("sim-1").value().description.kind, hardware::RigKind::kSimulated);
  EXPECT_EQ(rig_pool_.Acquire(LeaseOn("sim-1", 1)).value().rig().description().id, "sim-1");
}

TEST_F(RigPoolTest, AStrangerIsShownAndIsNoRig) {
  rig_pool_.SetUnprovenRigs([] {
    std::vector<RigStatus> strangers(2);
    strangers[0].description.id = "sim-1";  // the name of a rig of this pool
    strangers[1].description.id = "stranger";
    return strangers;
  });
  const auto strangers = rig_pool_.ListUnprovenRigs();
  ASSERT_EQ(strangers.size(), 1u);
  EXPECT_EQ(strangers[0].description.id, "stranger");
  EXPECT_EQ(rig_pool_.List().size(), 2u);
  EXPECT_EQ(rig_pool_.Find("stranger").error().code, core::ErrorCode::kNotFound);
  EXPECT_EQ(rig_pool_.Acquire(LeaseOn("stranger", 1)).error().code, core::ErrorCode::kNotFound);
}

TEST_F(RigPoolTest, StopsTheRigWhenAHoldEnds) {
  { auto hold = rig_pool_.Acquire(LeaseOn("sim-2", 1)); }
  ASSERT_EQ(last_->stops().size(), 1u);
  EXPECT_FALSE(rig_pool_.List()[1].leased);
}

TEST_F(RigPoolTest, NamesAnUnknownRig) {
  const auto unknown = rig_pool_.Acquire(LeaseOn("sim-9", 1));
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().code, core::ErrorCode::kNotFound);
  EXPECT_NE(unknown.error().message.find("sim-9"), std::string::npos);
}

TEST_F(RigPoolTest, StaysFreeWhenARigCannotBeBuilt) {
  while_it_is_made_ = [] { throw std::runtime_error("no device"); };
  EXPECT_THROW(static_cast<void>(rig_pool_.Acquire(LeaseOn("sim-1", 1))), std::runtime_error);
  while_it_is_made_ = {};
  EXPECT_TRUE(rig_pool_.Acquire(LeaseOn("sim-1", 1)).ok());
}

/// A simulated bench whose shaft is held: at 5 V the stall trips within a second.
core::Status RunWithHeldShaft(hardware::Rig& rig, hardware::Epoch epoch) {
  hardware::RunPlan plan;
  plan.uc_v.assign(200, 5.0);
  plan.faults = {{.component = paper::kB, .value = 1.0, .at_s = 0.0}};
  core::Status status = rig.Arm(plan, epoch);
  if (status.ok()) status = rig.Start(epoch);
  if (status.ok()) (void)hardware::Drain(rig);
  return status;
}

TEST(ResidentRig, KeepsItsTripBetweenLeasesUntilItIsCleared) {
  RigPool rig_pool;
  hardware::SimulatedRigOptions options;
  options.id = "bench-1";
  options.kind = hardware::RigKind::kBench;
  options.speed = 0.0;
  rig_pool.AddResident(hardware::MakeSimulatedRig(options), "bench");
  {
    auto hold = rig_pool.Acquire(LeaseOn("bench-1", 1));
    ASSERT_TRUE(hold.ok());
    ASSERT_TRUE(RunWithHeldShaft(hold.value().rig(), hold.value().epoch()).ok());
  }
  const RigStatus tripped = rig_pool.List().front();
  EXPECT_EQ(tripped.state, hardware::RigState::kTripped);
  ASSERT_TRUE(tripped.trip.has_value());
  EXPECT_EQ(tripped.trip->name, "stall");
  EXPECT_GT(tripped.trip->value, tripped.trip->limit);
  EXPECT_GT(tripped.trip->t_s, 0.4);
  EXPECT_GT(tripped.loop.lateness.count(), 50u);
  {
    auto next = rig_pool.Acquire(LeaseOn("bench-1", 2));
    ASSERT_TRUE(next.ok());
    EXPECT_EQ(RunWithHeldShaft(next.value().rig(), next.value().epoch()).error().code,
              core::ErrorCode::kConflict);
    hardware::RigCommand clear;
    clear.kind = hardware::RigCommand::Kind::kClearTrip;
    EXPECT_TRUE(next.value().rig().Command(next.value().epoch(), clear).ok());
  }
  EXPECT_EQ(rig_pool.List().front().state, hardware::RigState::kIdle);
  EXPECT_FALSE(rig_pool.List().front().trip.has_value());
}

TEST(PracticeRig, IsAnotherBenchForTheNextButItsTicksAreAddedUp) {
  RigPool rig_pool;
  hardware::SimulatedRigOptions options;
  options.speed = 0.0;
  const auto description = hardware::MakeSimulatedRig(options)->description();
  rig_pool.Add(description, "bench", [options] {
    return std::shared_ptr<hardware::Rig>(hardware::MakeSimulatedRig(options));
  });
  std::uint64_t ticks = 0;
  for (std::uint64_t round = 1; round <= 2; ++round) {
    {
      auto hold = rig_pool.Acquire(LeaseOn(description.id, round));
      ASSERT_TRUE(hold.ok());
      ASSERT_TRUE(RunWithHeldShaft(hold.value().rig(), hold.value().epoch()).ok()) << round;
    }
    EXPECT_FALSE(rig_pool.List().front().trip.has_value());
    EXPECT_GT(rig_pool.List().front().loop.lateness.count(), ticks);
    ticks = rig_pool.List().front().loop.lateness.count();
  }
}

}  // namespace
}  // namespace faultlab::server
