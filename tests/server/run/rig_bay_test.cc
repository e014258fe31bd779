#include "server/run/rig_bay.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/rig_runs.h"
#include "tests/server/run/fake_rig.h"

namespace faultlab::server {
namespace {

using tests::FakeRig;

hardware::RigDescription Simulated(const std::string& id) {
  hardware::RigDescription description;
  description.id = id;
  description.kind = hardware::RigKind::kSimulated;
  return description;
}

class RigBayTest : public ::testing::Test {
 protected:
  RigBayTest() {
    for (const char* id : {"sim-1", "sim-2"}) {
      bay_.Add(Simulated(id), "bench", hardware::Epoch{10}, [this, id] {
        last_ = std::make_shared<FakeRig>(id);
        return last_;
      });
    }
  }
  RigBay bay_;
  std::shared_ptr<FakeRig> last_;
};

TEST_F(RigBayTest, LeasesAnyFreeSimulatedRigUntilNoneIsLeft) {
  auto a = bay_.Acquire("");
  auto b = bay_.Acquire("");
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NE(a.value().rig().description().id, b.value().rig().description().id);
  const auto none = bay_.Acquire("");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, core::ErrorCode::kBusy);
  a.value().Release();
  EXPECT_TRUE(bay_.Acquire("").ok());
}

TEST_F(RigBayTest, LeasesEveryRigThatTurnsUpHoweverManyThereAre) {
  int count = 0;
  bay_.SetFinder([&] {
    std::vector<RigBay::Found> found;
    for (int i = 0; i < count; ++i) {
      const std::string id = "far-" + std::to_string(i);
      RigStatus status;
      status.description = Simulated(id);
      status.description.kind = hardware::RigKind::kRemote;
      found.push_back({std::move(status), [id] { return std::make_shared<FakeRig>(id); }});
    }
    return found;
  });
  for (count = 1; count <= 20; ++count) {
    EXPECT_EQ(bay_.List().size(), static_cast<std::size_t>(2 + count));
    const std::string id = "far-" + std::to_string(count - 1);
    const auto lease = bay_.Acquire(id);
    ASSERT_TRUE(lease.ok()) << lease.error().message;
    EXPECT_EQ(lease.value().rig().description().id, id);
  }
}

TEST_F(RigBayTest, RaisesTheEpochWithEachLease) {
  const auto first = bay_.Acquire("sim-1").value().epoch();
  const auto second = bay_.Acquire("sim-1").value().epoch();
  EXPECT_EQ(first, hardware::Epoch{11});
  EXPECT_EQ(second, hardware::Epoch{12});
}

TEST_F(RigBayTest, StopsTheRigWhenALeaseEnds) {
  { auto lease = bay_.Acquire("sim-2"); }
  ASSERT_EQ(last_->stops().size(), 1u);
  EXPECT_FALSE(bay_.List()[1].leased);
}

TEST_F(RigBayTest, NamesAnUnknownRig) {
  const auto unknown = bay_.Acquire("sim-9");
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().code, core::ErrorCode::kNotFound);
  EXPECT_NE(unknown.error().message.find("sim-9"), std::string::npos);
}

TEST_F(RigBayTest, StaysFreeWhenARigCannotBeBuilt) {
  RigBay bay;
  bool fail = true;
  bay.Add(Simulated("sim-1"), "bench", hardware::Epoch{0}, [&]() -> std::shared_ptr<FakeRig> {
    if (fail) throw std::runtime_error("no device");
    return std::make_shared<FakeRig>("sim-1");
  });
  EXPECT_THROW(static_cast<void>(bay.Acquire("sim-1")), std::runtime_error);
  fail = false;
  EXPECT_TRUE(bay.Acquire("sim-1").ok());
}

/// A simulated bench whose shaft is held: 5 V stall it within a second.
core::Status RunWithHeldShaft(hardware::Rig& rig, hardware::Epoch epoch) {
  hardware::RunPlan plan;
  plan.uc_v.assign(200, 5.0);
  plan.faults = {{.component = core::Component::kB, .value = 1.0, .at_s = 0.0}};
  core::Status status = rig.Arm(plan, epoch);
  if (status.ok()) status = rig.Start(epoch);
  if (status.ok()) (void)hardware::Drain(rig);
  return status;
}

TEST(ResidentRig, KeepsItsTripBetweenLeasesUntilItIsCleared) {
  RigBay bay;
  hardware::SimulatedRigOptions options;
  options.id = "bench-1";
  options.kind = hardware::RigKind::kBench;
  options.speed = 0.0;
  bay.AddResident(hardware::MakeSimulatedRig(options), "bench");
  EXPECT_EQ(bay.ClearTrip("bench-1").error().code, core::ErrorCode::kConflict)
      << "nothing holds it";
  {
    auto lease = bay.Acquire("bench-1");
    ASSERT_TRUE(lease.ok());
    ASSERT_TRUE(RunWithHeldShaft(lease.value().rig(), lease.value().epoch()).ok());
    EXPECT_EQ(bay.ClearTrip("bench-1").error().code, core::ErrorCode::kBusy) << "leased";
  }
  const RigStatus tripped = bay.List().front();
  EXPECT_EQ(tripped.state, hardware::RigState::kTripped);
  ASSERT_TRUE(tripped.trip.has_value());
  EXPECT_EQ(tripped.trip->name, "stall");
  EXPECT_GT(tripped.trip->value, tripped.trip->limit);
  EXPECT_GT(tripped.trip->t_s, 0.4);
  EXPECT_GT(tripped.loop.lateness.count(), 50u);
  {
    auto next = bay.Acquire("bench-1");
    ASSERT_TRUE(next.ok());
    EXPECT_EQ(RunWithHeldShaft(next.value().rig(), next.value().epoch()).error().code,
              core::ErrorCode::kConflict);
  }
  EXPECT_TRUE(bay.ClearTrip("bench-1").ok());
  EXPECT_EQ(bay.List().front().state, hardware::RigState::kIdle);
  EXPECT_FALSE(bay.List().front().trip.has_value());
}

TEST(PracticeRig, IsAnotherBenchForTheNextButItsTicksAreAddedUp) {
  RigBay bay;
  hardware::SimulatedRigOptions options;
  options.speed = 0.0;
  const auto description = hardware::MakeSimulatedRig(options)->description();
  bay.Add(description, "bench", hardware::Epoch{0}, [options] {
    return std::shared_ptr<hardware::Rig>(hardware::MakeSimulatedRig(options));
  });
  std::uint64_t ticks = 0;
  for (int round = 0; round < 2; ++round) {
    {
      auto lease = bay.Acquire("");
      ASSERT_TRUE(lease.ok());
      ASSERT_TRUE(RunWithHeldShaft(lease.value().rig(), lease.value().epoch()).ok()) << round;
    }
    EXPECT_FALSE(bay.List().front().trip.has_value());
    EXPECT_GT(bay.List().front().loop.lateness.count(), ticks);
    ticks = bay.List().front().loop.lateness.count();
  }
}

}  // namespace
}  // namespace faultlab::server
