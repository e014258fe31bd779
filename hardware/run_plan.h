#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/control/speed_reference.h"
#include "core/control/tolerant_drive.h"
#include "core/types/fault.h"

namespace faultlab::hardware {

/// The rig keeps its speed by itself: from sample `from` on, and not before it has been told what
/// rig it is (RigCommand::Kind::kControl). Until then it plays the plan's uc_v.
struct SpeedControlPlan {
  core::SpeedReference reference;  ///< begins at `from`
  core::ToleranceOptions options;
  std::int64_t from = 0;
};

/// All that a rig must know before it starts: uploaded whole, so that the loop never waits for a
/// network.
struct RunPlan {
  std::vector<double> uc_v;         ///< control voltage of each sample; size() / rate = duration
  std::vector<core::Fault> faults;  ///< schedule, run time; live commands come on top
  double period_s = 0.01;
  std::optional<SpeedControlPlan> control{};
  std::uint64_t seed = 1;  ///< noise of a simulated rig; real rigs ignore it
};

}  // namespace faultlab::hardware
