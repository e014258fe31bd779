#pragma once

#include <string>

#include "core/types/result.h"
#include "server/config.h"

namespace faultlab::server {

/// The address at which the other servers of the database reach this one: from the settings,
/// otherwise the address on which it listens. Empty for a server that listens on every address and
/// has no such setting.
core::Result<std::string> MemberAddress(const Config& config, const std::string& listening);

}  // namespace faultlab::server
