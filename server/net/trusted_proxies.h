#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::server {

/// Addresses of proxies whose statements about the client are trusted.
class TrustedProxies {
 public:
  /// "10.0.0.2", "10.1.0.0/16", "2001:db8::/32"; kInvalid names the text that is not an address.
  static core::Result<TrustedProxies> Parse(const std::vector<std::string>& texts);

  bool Has(std::string_view address) const;

 private:
  struct Network {
    std::array<unsigned char, 16> bytes{};  ///< IPv4 as ::ffff:a.b.c.d
    int bits = 128;
  };
  std::vector<Network> networks_;
};

}  // namespace faultlab::server
