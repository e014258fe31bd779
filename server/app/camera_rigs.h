#pragma once

#include "core/types/result.h"
#include "server/config.h"
#include "server/run/rig_bay.h"

namespace faultlab::server {

/// Refuses a camera whose rig this server cannot have: it simulates none of that name, and has no
/// key of a far one.
/// @param bay  with the simulated rigs
core::Status CheckCameraRigs(const Config& config, const RigBay& bay);

}  // namespace faultlab::server
