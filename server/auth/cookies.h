#pragma once

#include <string_view>

namespace faultlab::server {

inline constexpr std::string_view kSessionCookieName = "faultlab_session";
/// Shows that this browser has signed in before. It does not authenticate; it only exempts the
/// browser from the limits that others' wrong tries cause.
inline constexpr std::string_view kDeviceCookieName = "faultlab_device";

/// The value of one cookie of a Cookie header; empty when it is not there.
std::string_view CookieValue(std::string_view header, std::string_view name);

}  // namespace faultlab::server
