#pragma once

#include <string_view>

namespace faultlab::server {

/// Begins the login of an account whose person was erased; the number of the account follows.
/// Nobody else's login begins so.
inline constexpr std::string_view kErasedLogin = "erased-";

}  // namespace faultlab::server
