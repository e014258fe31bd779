#pragma once

#include <string_view>

namespace faultlab::server {

inline constexpr std::string_view kSessionCookieName = "faultlab_session";
/// Says that this browser has signed in before: it proves nothing, but a stranger's wrong tries do
/// not slow it down.
inline constexpr std::string_view kDeviceCookieName = "faultlab_device";

/// The value of one cookie of a Cookie header; empty when it is not there.
std::string_view CookieValue(std::string_view header, std::string_view name);

}  // namespace faultlab::server
