// The lab around runs, without HTTP: what a rig may be used for before the scheduler knows it.
#include "server/app/lab_system.h"

#include <gtest/gtest.h>

#include "hardware/simulated/simulated_rig.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;

class LabSystemTest : public testing::Test {
 protected:
  LabSystemTest() : database_(Engine::kSqlite) {
    LabSystem::Options options;
    options.server_id = "local";
    options.log = [](std::string_view) {};
    auto opened = LabSystem::Open(*database_, accounts_, api_, std::move(options));
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    lab_ = std::move(opened).value();
  }
  ~LabSystemTest() override { lab_->Stop(); }

  void AddRig(const std::string& id, hardware::RigKind kind) {
    hardware::SimulatedRigOptions options;
    options.id = id;
    options.kind = kind;
    bay_.AddResident(hardware::MakeSimulatedRig(options), "bench");
  }
  core::Status GuestMayUse(const std::string& rig) { return api_.may_use_rig(Principal{}, rig); }

  tests::TestDatabase database_;
  SystemClock clock_;
  RecordingStore store_{*database_};
  RigCalibrations calibrations_{*database_};
  RigBay bay_;
  StreamHub hub_{{}, clock_};
  StreamTokens tokens_{clock_};
  Accounts accounts_{*database_, GuestAccess::kEverywhere};
  RunManager runs_{{}, bay_, store_, hub_, clock_, [](std::string_view) {}};
  ApiContext api_{runs_, bay_, store_, calibrations_, hub_, tokens_, accounts_, clock_};
  std::unique_ptr<LabSystem> lab_;
};

TEST_F(LabSystemTest, LetsNobodyUseABenchInTheMomentInWhichItIsFound) {
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

TEST_F(LabSystemTest, LetsEverybodyUseASimulatorAndNobodyANameThatIsNoRig) {
  AddRig("sim-1", hardware::RigKind::kSimulated);
  EXPECT_TRUE(GuestMayUse("sim-1").ok());
  ASSERT_FALSE(GuestMayUse("nowhere").ok());
  EXPECT_EQ(GuestMayUse("nowhere").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace faultlab::server
