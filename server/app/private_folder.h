#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "core/types/result.h"

namespace faultlab::server {

/// Makes the data folder if it is not there, and takes others' rights to it and to the database in
/// it away, which `warn` tells. kUnavailable when it cannot be made.
core::Status MakePrivateFolder(const std::string& folder,
                               const std::function<void(std::string_view)>& warn);

}  // namespace faultlab::server
