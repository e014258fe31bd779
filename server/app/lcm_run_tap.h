#pragma once

#include <memory>
#include <string>

#include "core/types/result.h"
#include "server/run/run_manager.h"

namespace faultlab::server {

/// Sends every run's samples, estimates and events to an LCM bus: see hardware/lcm/lcm_tap.h.
core::Result<std::unique_ptr<RunTap>> OpenLcmRunTap(const std::string& url);

}  // namespace faultlab::server
