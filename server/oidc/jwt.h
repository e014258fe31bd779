#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/oidc/jwk.h"

namespace faultlab::server::oidc {

/// What stands in front of a token's signature: read before any key is looked at.
struct JwtHeader {
  SignatureKind kind = SignatureKind::kRs256;
  std::string kid;  ///< empty if the token names no key
};

/// A token that was taken apart, nothing of it proved.
struct UnprovedJwt {
  JwtHeader header;
  std::string signed_text;  ///< "header.payload"
  std::string payload;      ///< bytes of the claims
  std::string signature;
};

/// kInvalid for whatever is not three parts of strict base64url with RS256 or ES256 in the header,
/// and for `crit`: extensions that we do not know.
core::Result<UnprovedJwt> TakeApart(std::string_view token);

/// The key that a token names; without a name, the only one of its kind. Null if there is none.
const Jwk* KeyOf(const JwtHeader& header, const std::vector<Jwk>& keys);

/// The claims, when the key's signature is under them.
core::Result<boost::json::object> Prove(const UnprovedJwt& token, const Jwk& key);

}  // namespace faultlab::server::oidc
