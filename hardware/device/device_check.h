#pragma once

#include <cstdint>
#include <vector>

#include "core/types/result.h"
#include "hardware/bench_rig.h"
#include "hardware/device/messages.h"
#include "hardware/run_plan.h"

namespace faultlab::hardware {

/// Holds what a device says of itself against the description of its bench: relay lines, their
/// nominal positions and order. Channels that it lacks are taken out of the description. Throws
/// IoError that says what to change.
void CheckWiringOf(const DeviceInfo& info, BenchConfig& config, std::uint32_t nominal_lines);

/// Refuses a plan that the device cannot play: period, delta, codes of uc.
core::Status CheckPlanOf(const DeviceInfo& info, const BenchConfig& config, const RunPlan& plan);

/// uc of the plan as codes of the device's converter. Contract: CheckPlanOf has passed it.
std::vector<std::int16_t> CodesOf(const DeviceInfo& info,
                                  const BenchConfig& config,
                                  const RunPlan& plan);

}  // namespace faultlab::hardware
