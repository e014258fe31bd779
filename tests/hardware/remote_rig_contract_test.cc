// The contract of a Rig, kept by one that is far away: its agent and its server on one bus, which
// loses nothing and a tenth of all messages.
#include "tests/hardware/remote_world.h"
#include "tests/hardware/rig_contract.h"

namespace faultlab::hardware {
namespace {

constexpr double kFarSpeed = 10.0;

/// With the world that it needs.
class FarRig final : public Rig {
 public:
  explicit FarRig(const Weather& weather) : world_(weather, 21, kFarSpeed) {}
  const RigDescription& description() const override { return here().description(); }
  RigState state() const override { return here().state(); }
  core::Status Arm(RunPlan plan, Epoch epoch) override {
    return world_.rig().Arm(std::move(plan), epoch);
  }
  core::Status Start(Epoch epoch) override { return world_.rig().Start(epoch); }
  core::Status Command(Epoch epoch, const RigCommand& command) override {
    return world_.rig().Command(epoch, command);
  }
  void KeepAlive(Epoch epoch) override { world_.rig().KeepAlive(epoch); }
  ReadStatus Read(std::vector<RigMessage>& out, std::chrono::milliseconds patience) override {
    return world_.rig().Read(out, patience);
  }
  void Fence(Epoch epoch) override { world_.rig().Fence(epoch); }
  void SafeStop(std::string_view reason) override { world_.rig().SafeStop(reason); }
  core::Result<SelfTestReport> SelfTest(Epoch epoch) override {
    return world_.rig().SelfTest(epoch);
  }
  std::optional<Trip> trip() const override { return here().trip(); }
  LoopQuality loop_quality() const override { return here().loop_quality(); }

 private:
  const Rig& here() const { return *world_.server.shared_rig(); }

  FarWorld world_;
};

const RigUnderContract kFarRigs[] = {
    {"FarInFineWeather",
     []() -> std::unique_ptr<Rig> { return std::make_unique<FarRig>(Weather{}); },
     [] { return SquarePlan(kSamples); },
     0.0,
     /*is_far=*/true},
    {"FarInAStorm",
     []() -> std::unique_ptr<Rig> {
       return std::make_unique<FarRig>(Weather{.loss = 0.1, .duplicate = 0.1, .reorder = 0.1});
     },
     [] { return SquarePlan(kSamples); },
     0.0,
     /*is_far=*/true},
};

INSTANTIATE_TEST_SUITE_P(FarRigs, RigContract, testing::ValuesIn(kFarRigs), NameOfKind);

}  // namespace
}  // namespace faultlab::hardware
