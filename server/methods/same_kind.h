#pragma once

#include <span>
#include <vector>

#include "core/bench/bench.h"
#include "core/isolability/isolability_options.h"

namespace faultlab::server {

/// Of each fault: its component, and those that no sensor separates from it under the bench's usual
/// excitation. A fault that cannot be judged stands alone.
std::vector<std::vector<core::Component>> SameKinds(const core::Bench& bench,
                                                    core::Channels channels,
                                                    std::span<const core::FaultSize> faults);

}  // namespace faultlab::server
