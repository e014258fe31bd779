#include "server/oidc/id_token.h"

#include <openssl/evp.h>
#include <openssl/sha.h>

#include <array>
#include <cmath>
#include <optional>

#include "server/oidc/base64url.h"
#include "server/oidc/claims.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;

constexpr double kSkewS = 60.0;
constexpr double kAgeMaxS = 600.0;

core::Error BadClaims(const std::string& what) {
  return {core::ErrorCode::kInvalid, "the ID token " + what, ""};
}

std::optional<double> Seconds(const json::object& claims, std::string_view name) {
  const json::value* value = claims.if_contains(name);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  const double seconds = value->to_number<double>();
  if (!std::isfinite(seconds)) return std::nullopt;
  return seconds;
}

/// The token is for this client; if it is for others too, it must state that this client requested
/// it.
bool IsForClient(const json::object& claims, const std::string& client_id) {
  const json::value* aud = claims.if_contains("aud");
  if (aud == nullptr) return false;
  const json::value* azp = claims.if_contains("azp");
  if (azp != nullptr && (!azp->is_string() || azp->get_string() != client_id)) return false;
  if (aud->is_string()) return aud->get_string() == client_id;
  if (!aud->is_array()) return false;
  bool named = false;
  for (const json::value& one : aud->get_array()) {
    if (!one.is_string()) return false;
    named = named || one.get_string() == client_id;
  }
  return named && (aud->get_array().size() == 1 || azp != nullptr);
}

}  // namespace

std::string HalfHash(std::string_view token) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> hash{};
  EVP_Digest(token.data(), token.size(), hash.data(), nullptr, EVP_sha256(), nullptr);
  return EncodeBase64Url({reinterpret_cast<const char*>(hash.data()), hash.size() / 2});
}

core::Status CheckIdToken(const json::object& claims, const ExpectedToken& expected) {
  if (TextOf(claims, "iss") != expected.issuer) return BadClaims("is of another issuer");
  if (!IsForClient(claims, expected.client_id)) return BadClaims("is for another client");
  const double now_s = static_cast<double>(ToMilliseconds(expected.now)) / 1000.0;
  const auto expires_s = Seconds(claims, "exp");
  const auto issued_s = Seconds(claims, "iat");
  if (!expires_s || !issued_s) return BadClaims("has no numbers exp and iat");
  if (now_s >= *expires_s + kSkewS) return BadClaims("has expired");
  if (*issued_s > now_s + kSkewS) return BadClaims("is of the future");
  if (*issued_s < now_s - kAgeMaxS - kSkewS) return BadClaims("is too old");
  if (claims.contains("nbf")) {
    const auto begins_s = Seconds(claims, "nbf");
    if (!begins_s || *begins_s > now_s + kSkewS) return BadClaims("is not valid yet");
  }
  if (expected.nonce.empty() || TextOf(claims, "nonce") != expected.nonce) {
    return BadClaims("answers another question (nonce)");
  }
  const std::string subject = TextOf(claims, "sub");
  if (subject.empty() || subject.size() > 255) return BadClaims("names nobody (sub)");
  if (claims.contains("at_hash") && TextOf(claims, "at_hash") != HalfHash(expected.access_token)) {
    return BadClaims("belongs to another access token");
  }
  return core::Done{};
}

}  // namespace faultlab::server::oidc
