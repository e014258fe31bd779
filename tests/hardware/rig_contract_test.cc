// The rigs of this process that need no device.
#include "tests/hardware/rig_contract.h"
#include "hardware/replay_rig.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

std::vector<core::Sample> Recording(int samples) {
  std::vector<core::Sample> recording;
  for (int k = 0; k < samples; ++k) {
    recording.push_back({.index = k, .t_s = k * 0.01, .uc_v = 2.0, .um_v = 4.8 + k * 1e-3});
  }
  return recording;
}

std::unique_ptr<Rig> MakeSimulated(const std::string& profile) {
  SimulatedRigOptions options;
  options.profile = profile;
  options.speed = 0.0;
  return MakeSimulatedRig(options);
}

const RigUnderContract kKinds[] = {
    {"SimulatedBench", [] { return MakeSimulated("bench"); }, [] { return SquarePlan(kSamples); }},
    {"SimulatedMultisim",
     [] { return MakeSimulated("multisim"); },
     [] { return SquarePlan(kSamples); }},
    {"Replay",
     [] {
       ReplayRigOptions options;
       options.bench = &paper::Bench();
       options.speed = 0.0;
       return MakeReplayRig(Recording(kSamples), options);
     },
     [] { return ReplayPlan(0.01); }},
};

INSTANTIATE_TEST_SUITE_P(Rigs, RigContract, testing::ValuesIn(kKinds), NameOfKind);

}  // namespace
}  // namespace faultlab::hardware
