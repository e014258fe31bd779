#pragma once

#include <string_view>

namespace faultlab::server {

/// Who the client is when its proxy does not say it by an address: no address of this machine, and
/// one name for all, so that they are counted together.
inline constexpr std::string_view kUnknownClient = "unknown";

/// The last entry of a list as proxies write it, without the spaces around it.
std::string_view LastListEntry(std::string_view list);

/// The address of an X-Forwarded-For entry, without port, brackets and zone: "203.0.113.9:5555",
/// "[2001:db8::1]:443"; kUnknownClient when there is none in it.
std::string_view ForwardedAddress(std::string_view entry);

}  // namespace faultlab::server
