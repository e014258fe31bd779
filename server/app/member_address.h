#pragma once

#include <string>

#include "core/types/result.h"
#include "server/config.h"

namespace faultlab::server {

/// Where the other servers of the database reach this one: as the settings say, else where it
/// listens. Empty for a server that listens on every address and is told none.
core::Result<std::string> MemberAddress(const Config& config, const std::string& listening);

}  // namespace faultlab::server
