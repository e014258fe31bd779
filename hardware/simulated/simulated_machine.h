#pragma once

#include <memory>

#include "hardware/bench_rig.h"
#include "hardware/simulated/simulated_rig.h"

namespace faultlab::hardware {

/// The bench that the options describe: ideal contacts, the profile's delta.
BenchConfig SimulatedBenchConfig(const SimulatedRigOptions& options);

/// A BenchRig's machine on a SimulatedDaq; for those who bring their own pace.
std::unique_ptr<RigMachine> MakeSimulatedMachine(const SimulatedRigOptions& options,
                                                 BenchConfig config,
                                                 std::shared_ptr<const Clock> clock);

}  // namespace faultlab::hardware
