#include "server/oidc/provider_documents.h"

#include <boost/json.hpp>

#include "server/oidc/claims.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;

constexpr std::size_t kLogBytesMax = 200;

core::Error Wrong(const std::string& what) {
  return {core::ErrorCode::kInvalid, "the provider's configuration " + what, ""};
}

bool Contains(const json::object& object, std::string_view list, std::string_view word) {
  const json::value* value = object.if_contains(list);
  if (value == nullptr || !value->is_array()) return false;
  for (const json::value& one : value->get_array()) {
    if (one.is_string() && one.get_string() == word) return true;
  }
  return false;
}

}  // namespace

std::string DiscoveryUrl(const std::string& issuer) {
  const std::string base = issuer.ends_with('/') ? issuer.substr(0, issuer.size() - 1) : issuer;
  return base + "/.well-known/openid-configuration";
}

std::string ForLog(std::string_view text) {
  std::string out(text.substr(0, kLogBytesMax));
  for (char& c : out) {
    if (c < ' ' || c > '~') c = '?';
  }
  return out;
}

core::Result<json::object> ObjectOf(const WebAnswer& answer, const std::string& what) {
  json::error_code error;
  const json::value value = json::parse(answer.body, error);
  const bool object = !error && value.is_object();
  if (answer.status == 200 && object) return value.get_object();
  std::string text = what + " answered " + std::to_string(answer.status);
  if (object) {
    text += " " + ForLog(TextOf(value.get_object(), "error")) + " " +
            ForLog(TextOf(value.get_object(), "error_description"));
  }
  return core::Error{core::ErrorCode::kUnavailable, text, ""};
}

core::Result<Discovery> ParseDiscovery(const WebAnswer& answer,
                                       const std::string& issuer,
                                       const WebClient& client) {
  TRY(const auto in, ObjectOf(answer, "the provider's configuration"));
  Discovery out;
  out.issuer = TextOf(in, "issuer");
  if (out.issuer != issuer) return Wrong("is of the issuer " + ForLog(out.issuer));
  out.authorization_endpoint = TextOf(in, "authorization_endpoint");
  out.token_endpoint = TextOf(in, "token_endpoint");
  out.jwks_uri = TextOf(in, "jwks_uri");
  out.userinfo_endpoint = TextOf(in, "userinfo_endpoint");
  for (const std::string& url : {out.authorization_endpoint, out.token_endpoint, out.jwks_uri}) {
    if (const core::Status good = client.CheckUrl(url); !good.ok()) return good.error();
  }
  if (!out.userinfo_endpoint.empty()) {
    if (const core::Status good = client.CheckUrl(out.userinfo_endpoint); !good.ok()) {
      return good.error();
    }
  }
  const json::value* says = in.if_contains("authorization_response_iss_parameter_supported");
  out.says_issuer = says != nullptr && says->is_bool() && says->get_bool();
  const std::string_view methods = "token_endpoint_auth_methods_supported";
  out.secret_in_form = in.contains(methods) && !Contains(in, methods, "client_secret_basic") &&
                       Contains(in, methods, "client_secret_post");
  return out;
}

}  // namespace faultlab::server::oidc
