#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "core/types/fault.h"
#include "server/clock.h"
#include "server/course/trials.h"
#include "server/run/run_manager.h"

namespace faultlab::server::course {

/// Stores what the rig confirmed of a trial when its run ends, or voids the trial: when the rig
/// failed ("rig_failed"), or when its relays did not do what was drawn ("relay_mismatch").
std::shared_ptr<SealedWitness> MakeWitness(Trials trials,
                                           std::int64_t trial,
                                           std::vector<core::Fault> drawn,
                                           const Clock& clock,
                                           std::function<void(std::string_view)> log);

}  // namespace faultlab::server::course
