#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// Under which an address is counted: an IPv4 address itself, of an IPv6 address its first 64 bits,
/// for whoever has one has all of them: "203.0.113.9", "2001:db8:1:2::/64". Text that is no address
/// comes back as it is.
std::string AddressKey(std::string_view address);

}  // namespace faultlab::server
