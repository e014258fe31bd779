#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/oidc/https_client.h"

namespace faultlab::server::oidc {

/// What a provider says of itself at /.well-known/openid-configuration.
struct Discovery {
  std::string issuer;
  std::string authorization_endpoint;
  std::string token_endpoint;
  std::string userinfo_endpoint;  ///< empty: it has none
  std::string jwks_uri;
  bool says_issuer = false;     ///< its callbacks carry iss (RFC 9207)
  bool secret_in_form = false;  ///< it takes no Authorization header at the token endpoint
};

std::string DiscoveryUrl(const std::string& issuer);

/// kInvalid unless it is the document of exactly this issuer with addresses that may be asked.
core::Result<Discovery> ParseDiscovery(const WebAnswer& answer,
                                       const std::string& issuer,
                                       const HttpsClient& client);

/// The JSON object of an answer 200; else kUnavailable with `what` and the provider's error code.
core::Result<boost::json::object> ObjectOf(const WebAnswer& answer, const std::string& what);

/// A stranger's words for a log: printable ASCII, 200 bytes at most.
std::string ForLog(std::string_view text);

}  // namespace faultlab::server::oidc
