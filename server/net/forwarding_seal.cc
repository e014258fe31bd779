#include "server/net/forwarding_seal.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <array>
#include <charconv>
#include <chrono>
#include <cstdint>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

/// The clocks of two servers differ by at most 2 s (server/lab), and a hop may wait for a
/// connection.
constexpr std::chrono::milliseconds kForwardingLife{10'000};

std::string_view Scheme(bool https) {
  return https ? "https" : "http";
}

/// HMAC-SHA256 as hex over the fields, each preceded by its length, so that different fields never
/// give the same text.
std::string Mac(const std::string& secret, std::initializer_list<std::string_view> fields) {
  std::string text;
  for (const std::string_view field : fields) {
    text.append(std::to_string(field.size())).append(":").append(field);
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> mac{};
  unsigned int size = 0;
  const unsigned char* made = HMAC(EVP_sha256(),
                                   secret.data(),
                                   static_cast<int>(secret.size()),
                                   reinterpret_cast<const unsigned char*>(text.data()),
                                   text.size(),
                                   mac.data(),
                                   &size);
  LAB_CHECK(made != nullptr);
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string hex;
  for (unsigned int i = 0; i < size; ++i) {
    hex.push_back(kHex[mac[i] >> 4]);
    hex.push_back(kHex[mac[i] & 15]);
  }
  return hex;
}

std::string_view TakeWord(std::string_view& rest) {
  const std::size_t end = rest.find(' ');
  const std::string_view word = rest.substr(0, end);
  rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  return word;
}

}  // namespace

std::string ForwardingSeal::Seal(const ForwardedRequest& hop,
                                 std::string_view receiver,
                                 const HttpRequest& request,
                                 WallTime now) const {
  const std::string at = std::to_string(ToMilliseconds(now));
  const std::string_view scheme = Scheme(hop.https);
  const std::string mac =
      Mac(secret_, {receiver, Name(request.method), request.target, at, scheme, hop.client});
  return at + " " + std::string(scheme) + " " + mac + " " + hop.client;
}

std::optional<ForwardedRequest> ForwardingSeal::Open(std::string_view value,
                                                     const HttpRequest& request,
                                                     WallTime now) const {
  const std::string_view at = TakeWord(value);
  const std::string_view scheme = TakeWord(value);
  const std::string_view mac = TakeWord(value);
  const std::string expected =
      Mac(secret_, {self_, Name(request.method), request.target, at, scheme, value});
  if (mac.size() != expected.size() ||
      CRYPTO_memcmp(mac.data(), expected.data(), expected.size()) != 0) {
    return std::nullopt;
  }
  std::int64_t at_ms = 0;
  (void)std::from_chars(at.data(), at.data() + at.size(), at_ms);  // sealed, so a server wrote it
  const auto age = now - FromMilliseconds(at_ms);
  if (age > kForwardingLife || age < -kForwardingLife) return std::nullopt;
  return ForwardedRequest{std::string(value), scheme == "https"};
}

}  // namespace faultlab::server
