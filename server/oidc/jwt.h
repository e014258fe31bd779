#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/oidc/jwk.h"

namespace faultlab::server::oidc {

/// The header of a token, read before any key is selected.
struct JwtHeader {
  SignatureKind kind = SignatureKind::kRs256;
  std::string kid;  ///< empty if the token names no key
};

/// A parsed token; nothing in it is verified yet.
struct UnprovedJwt {
  JwtHeader header;
  std::string signed_text;  ///< "header.payload"
  std::string payload;      ///< bytes of the claims
  std::string signature;
};

/// kInvalid for everything that is not three parts of strict base64url with RS256 or ES256 in the
/// header, and for `crit` (unknown extensions).
core::Result<UnprovedJwt> TakeApart(std::string_view token);

/// The key that a token names; if it names none, the only key of its kind. Null if there is none.
const Jwk* KeyOf(const JwtHeader& header, const std::vector<Jwk>& keys);

/// The claims, if the signature is valid for the key.
core::Result<boost::json::object> Prove(const UnprovedJwt& token, const Jwk& key);

}  // namespace faultlab::server::oidc
