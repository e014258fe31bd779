#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/wall_time.h"

namespace faultlab::server::oidc {

/// What an ID token must say to be the answer to our question (OpenID Connect Core 3.1.3.7).
struct ExpectedToken {
  std::string issuer;  ///< byte for byte
  std::string client_id;
  std::string nonce;
  std::string access_token;  ///< that came beside it; empty if none did
  WallTime now{};
};

/// Of claims whose signature was proved. 60 s are allowed for clocks that differ.
core::Status CheckIdToken(const boost::json::object& claims, const ExpectedToken& expected);

/// at_hash of an access token: the left half of its SHA-256.
std::string HalfHash(std::string_view token);

}  // namespace faultlab::server::oidc
