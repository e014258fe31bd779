#include "server/net/forwarding_seal.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <array>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <span>
#include <utility>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

/// The clocks of two servers differ by at most 2 s (server/lab), and a hop may wait for a
/// connection.
constexpr std::chrono::milliseconds kForwardingLife{10'000};
/// A seal is valid from so long before it was made to so long after.
constexpr std::chrono::milliseconds kRemembered = 2 * kForwardingLife;

std::string Hex(std::span<const unsigned char> bytes) {
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string hex;
  for (const unsigned char byte : bytes) {
    hex.push_back(kHex[byte >> 4]);
    hex.push_back(kHex[byte & 15]);
  }
  return hex;
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
  return Hex({mac.data(), size});
}

/// That was never drawn before, as far as chance allows.
std::string NewNumber() {
  std::array<unsigned char, 16> bytes{};
  LAB_CHECK(RAND_bytes(bytes.data(), bytes.size()) == 1);
  return Hex(bytes);
}

std::string_view TakeWord(std::string_view& rest) {
  const std::size_t end = rest.find(' ');
  const std::string_view word = rest.substr(0, end);
  rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  return word;
}

}  // namespace

std::string BodyHash(std::string_view body) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned int size = 0;
  LAB_CHECK(EVP_Digest(body.data(), body.size(), hash.data(), &size, EVP_sha256(), nullptr) == 1);
  return Hex({hash.data(), size});
}

std::string ForwardingSeal::Seal(const ForwardedRequest& hop,
                                 std::string_view receiver,
                                 const HttpRequest& request,
                                 WallTime now) const {
  const std::string at = std::to_string(ToMilliseconds(now));
  const std::string_view scheme = hop.https ? "https" : "http";
  const std::string number = NewNumber();
  const std::string body = BodyHash(request.body);
  const std::string mac =
      Mac(secret_,
          {receiver, Name(request.method), request.target, at, scheme, number, body, hop.client});
  return at + " " + std::string(scheme) + " " + number + " " + body + " " + mac + " " + hop.client;
}

std::optional<ForwardedRequest> ForwardingSeal::Open(std::string_view value,
                                                     const HttpRequest& request,
                                                     WallTime now) const {
  const std::string_view at = TakeWord(value);
  const std::string_view scheme = TakeWord(value);
  const std::string_view number = TakeWord(value);
  const std::string_view body = TakeWord(value);
  const std::string_view mac = TakeWord(value);
  const std::string expected =
      Mac(secret_, {self_, Name(request.method), request.target, at, scheme, number, body, value});
  if (mac.size() != expected.size() ||
      CRYPTO_memcmp(mac.data(), expected.data(), expected.size()) != 0) {
    return std::nullopt;
  }
  std::int64_t at_ms = 0;
  (void)std::from_chars(at.data(), at.data() + at.size(), at_ms);  // sealed, so a server wrote it
  const WallTime made = FromMilliseconds(at_ms);
  if (now - made > kForwardingLife || made - now > kForwardingLife) return std::nullopt;
  {
    const std::lock_guard lock(opened_->mutex);
    if (now - opened_->turned > kRemembered || opened_->turned - now > kRemembered) {
      opened_->older = std::exchange(opened_->newer, {});
      opened_->turned = now;
    }
    if (opened_->older.contains(number) || !opened_->newer.emplace(number).second) {
      return std::nullopt;
    }
  }
  return ForwardedRequest{std::string(value), scheme == "https", std::string(body)};
}

}  // namespace faultlab::server
