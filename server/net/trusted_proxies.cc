#include "server/net/trusted_proxies.h"

#include <arpa/inet.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace faultlab::server {
namespace {

using Bytes = std::array<unsigned char, 16>;
constexpr int kMappedBits = 96;  ///< prefix of an IPv4 address
constexpr int kByteBits = 8;

struct Address {
  Bytes bytes{};
  bool v4 = false;
};

std::optional<Address> ParseAddress(const std::string& text) {
  Address out;
  if (inet_pton(AF_INET6, text.c_str(), out.bytes.data()) == 1) return out;
  out.bytes = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
  out.v4 = true;
  constexpr std::size_t kMappedBytes = 12;
  if (inet_pton(AF_INET, text.c_str(), out.bytes.data() + kMappedBytes) == 1) return out;
  return std::nullopt;
}

bool SamePrefix(const Bytes& a, const Bytes& b, int bits) {
  const auto whole = static_cast<std::size_t>(bits / kByteBits);
  if (!std::equal(a.begin(), a.begin() + whole, b.begin())) return false;
  const int rest = bits % kByteBits;
  return rest == 0 || ((a[whole] ^ b[whole]) >> (kByteBits - rest)) == 0;
}

}  // namespace

core::Result<TrustedProxies> TrustedProxies::Parse(const std::vector<std::string>& texts) {
  TrustedProxies out;
  for (const std::string& text : texts) {
    const std::size_t slash = text.find('/');
    const auto address = ParseAddress(text.substr(0, slash));
    const int first = address && address->v4 ? kMappedBits : 0;
    int bits = 128 - first;
    bool good = address.has_value();
    if (good && slash != std::string::npos) {
      const int most = bits;
      const char* end = text.data() + text.size();
      const auto [stop, ec] = std::from_chars(text.data() + slash + 1, end, bits);
      good = ec == std::errc() && stop == end && bits >= 0 && bits <= most;
    }
    if (!good) {
      return core::Error{core::ErrorCode::kInvalid,
                         "'" + text + "' is neither an address nor a network such as 10.1.0.0/16",
                         "trusted_proxies"};
    }
    out.networks_.push_back({address->bytes, first + bits});
  }
  return out;
}

bool TrustedProxies::Has(std::string_view address) const {
  if (networks_.empty()) return false;
  const auto parsed = ParseAddress(std::string(address.substr(0, address.find('%'))));
  if (!parsed) return false;
  return std::ranges::any_of(networks_, [&](const Network& network) {
    return SamePrefix(network.bytes, parsed->bytes, network.bits);
  });
}

}  // namespace faultlab::server
