#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/wall_time.h"

namespace faultlab::server::oidc {

/// The claims that an ID token must have to be the answer to the request (OpenID Connect Core
/// 3.1.3.7).
struct ExpectedToken {
  std::string issuer;  ///< byte for byte
  std::string client_id;
  std::string nonce;
  std::string access_token;  ///< received together with it; empty if none was
  WallTime now{};
};

/// Checks claims whose signature is already verified. Clocks may differ by 60 s.
core::Status CheckIdToken(const boost::json::object& claims, const ExpectedToken& expected);

/// at_hash of an access token: the left half of its SHA-256.
std::string HalfHash(std::string_view token);

}  // namespace faultlab::server::oidc
