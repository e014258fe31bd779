#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// The key under which an address is counted: an IPv4 address itself, of an IPv6 address its first
/// 64 bits, because the holder of one has all of them: "203.0.113.9", "2001:db8:1:2::/64". Text
/// that is not an address is returned unchanged.
std::string AddressKey(std::string_view address);

}  // namespace faultlab::server
