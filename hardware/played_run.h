#pragma once

#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// Plays a plan to its end on a rig that is idle, leaves the rig safe. Blocks as long as the rig's
/// pace needs, at most 27 s beyond the plan.
/// @param what  names the run in errors: "the check"
/// @returns its samples; an error for a refusal (as the rig gave it), an interlock that tripped, or
/// a run that did not end. kBusy: the rig heard nothing from us in time, which says nothing of it.
core::Result<std::vector<core::Sample>> PlayRun(Rig& rig,
                                                Epoch epoch,
                                                RunPlan plan,
                                                std::string_view what);

}  // namespace faultlab::hardware
