#include "server/address_key.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

namespace faultlab::server {

std::string AddressKey(std::string_view address) {
  const std::string text(address.substr(0, std::min(address.find('%'), address.size())));
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  if (inet_pton(AF_INET6, text.c_str(), bytes.data()) != 1) return std::string(address);
  std::array<char, INET6_ADDRSTRLEN> out{};
  constexpr std::array<unsigned char, 12> kMappedIpv4 = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
  if (std::equal(kMappedIpv4.begin(), kMappedIpv4.end(), bytes.begin())) {
    inet_ntop(AF_INET, bytes.data() + kMappedIpv4.size(), out.data(), out.size());
    return out.data();
  }
  std::fill(bytes.begin() + bytes.size() / 2, bytes.end(), 0);
  inet_ntop(AF_INET6, bytes.data(), out.data(), out.size());
  return std::string(out.data()) + "/64";
}

}  // namespace faultlab::server
