#pragma once

#include "core/types/result.h"
#include "server/config.h"
#include "server/run/rig_pool.h"

namespace faultlab::server {

/// Refuses a camera whose rig this server cannot have: it simulates none of that name, and has no
/// key of a far one.
/// @param rig_pool  with the simulated rigs
core::Status CheckCameraRigs(const Config& config, const RigPool& rig_pool);

}  // namespace faultlab::server
