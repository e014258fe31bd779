#include "server/oidc/jwt.h"

#include <boost/json.hpp>

#include "server/oidc/base64url.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;

constexpr std::size_t kTokenBytesMax = 32 << 10;

core::Error BadToken(const std::string& what) {
  return {core::ErrorCode::kInvalid, "the token " + what, ""};
}

core::Result<JwtHeader> ParseHeader(std::string_view part) {
  const auto text = DecodeBase64Url(part);
  if (!text) return BadToken("has a header that is not base64url");
  json::error_code error;
  const json::value value = json::parse(*text, error);
  if (error || !value.is_object()) return BadToken("has a header that is no JSON object");
  const json::object& header = value.get_object();
  const json::value* alg = header.if_contains("alg");
  const auto kind =
      alg != nullptr && alg->is_string() ? ParseSignatureKind(alg->get_string()) : std::nullopt;
  if (!kind) return BadToken("is not signed with RS256 or ES256");
  if (header.contains("crit")) return BadToken("needs extensions (crit)");
  JwtHeader out;
  out.kind = *kind;
  if (const json::value* kid = header.if_contains("kid")) {
    if (!kid->is_string()) return BadToken("has a kid that is no text");
    out.kid = std::string(kid->get_string());
  }
  return out;
}

}  // namespace

core::Result<UnprovedJwt> TakeApart(std::string_view token) {
  if (token.size() > kTokenBytesMax) return BadToken("is too long");
  const std::size_t first = token.find('.');
  const std::size_t second = first == std::string_view::npos ? first : token.find('.', first + 1);
  if (second == std::string_view::npos || token.find('.', second + 1) != std::string_view::npos) {
    return BadToken("has not three parts");
  }
  TRY(auto header, ParseHeader(token.substr(0, first)));
  auto payload = DecodeBase64Url(token.substr(first + 1, second - first - 1));
  auto signature = DecodeBase64Url(token.substr(second + 1));
  if (!payload || !signature || signature->empty()) return BadToken("is not strict base64url");
  return UnprovedJwt{std::move(header),
                     std::string(token.substr(0, second)),
                     std::move(*payload),
                     std::move(*signature)};
}

const Jwk* KeyOf(const JwtHeader& header, const std::vector<Jwk>& keys) {
  const Jwk* found = nullptr;
  for (const Jwk& key : keys) {
    if (key.kind != header.kind || (!header.kid.empty() && key.kid != header.kid)) continue;
    if (found != nullptr) return nullptr;  // ambiguous: two keys match
    found = &key;
  }
  return found;
}

core::Result<json::object> Prove(const UnprovedJwt& token, const Jwk& key) {
  if (key.kind != token.header.kind) return BadToken("names a key of another kind");
  if (!Verifies(key, token.signed_text, token.signature)) {
    return BadToken("has a signature that is not the provider's");
  }
  json::error_code error;
  const json::value claims = json::parse(token.payload, error);
  if (error || !claims.is_object()) return BadToken("has claims that are no JSON object");
  return claims.get_object();
}

}  // namespace faultlab::server::oidc
