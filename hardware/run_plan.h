#pragma once

#include <cstdint>
#include <vector>

#include "core/types/fault.h"
#include "core/types/plant_parameters.h"

namespace faultlab::hardware {

/// All that a rig must know before it starts: uploaded whole, so that the loop never waits for a
/// network.
struct RunPlan {
  std::vector<double> uc_v;         ///< control voltage of each sample; size() / rate = duration
  std::vector<core::Fault> faults;  ///< schedule, run time; live commands come on top
  double period_s = 0.01;
  std::uint64_t seed = 1;  ///< noise of a simulated rig; real rigs ignore it
};

}  // namespace faultlab::hardware
