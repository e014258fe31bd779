#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/web_client/web_client.h"

namespace faultlab::server::oidc {

/// The provider's description at /.well-known/openid-configuration.
struct Discovery {
  std::string issuer;
  std::string authorization_endpoint;
  std::string token_endpoint;
  std::string userinfo_endpoint;  ///< empty if it has none
  std::string jwks_uri;
  bool says_issuer = false;     ///< its callbacks contain iss (RFC 9207)
  bool secret_in_form = false;  ///< its token endpoint does not accept an Authorization header
};

std::string DiscoveryUrl(const std::string& issuer);

/// kInvalid unless it is the document of exactly this issuer, with addresses that may be requested.
core::Result<Discovery> ParseDiscovery(const WebAnswer& answer,
                                       const std::string& issuer,
                                       const WebClient& client);

/// The JSON object of an answer with status 200; otherwise kUnavailable with `what` and the
/// provider's error code.
core::Result<boost::json::object> ObjectOf(const WebAnswer& answer, const std::string& what);

/// Untrusted text for a log: printable ASCII, at most 200 bytes.
std::string ForLog(std::string_view text);

}  // namespace faultlab::server::oidc
