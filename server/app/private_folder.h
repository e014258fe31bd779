#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "core/types/result.h"

namespace faultlab::server {

/// Makes the data folder if it does not exist, and removes other users' rights to it and to the
/// database in it, with a message to `warn`. kUnavailable when it cannot be made.
core::Status MakePrivateFolder(const std::string& folder,
                               const std::function<void(std::string_view)>& warn);

}  // namespace faultlab::server
