#pragma once

#include <string_view>

namespace faultlab::server {

/// The client when its proxy does not give an address. It is not an address of this machine, and
/// the same name for all, so that they are counted together.
inline constexpr std::string_view kUnknownClient = "unknown";

/// The last entry of a comma-separated list, as proxies write it, without surrounding spaces.
std::string_view LastListEntry(std::string_view list);

/// The address of an X-Forwarded-For entry, without port, brackets and zone: "203.0.113.9:5555",
/// "[2001:db8::1]:443"; kUnknownClient if it contains none.
std::string_view ForwardedAddress(std::string_view entry);

}  // namespace faultlab::server
