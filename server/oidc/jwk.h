#pragma once

#include <boost/json/object.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

struct evp_pkey_st;

namespace faultlab::server::oidc {

/// How a token may be signed: nothing else is taken, "none" and HS256 least of all.
enum class SignatureKind { kRs256, kEs256 };
std::optional<SignatureKind> ParseSignatureKind(std::string_view alg);

/// A public key of a provider. Good for one kind of signature, whatever a token says.
struct Jwk {
  std::string kid;  ///< empty if the provider names none
  SignatureKind kind = SignatureKind::kRs256;
  std::shared_ptr<evp_pkey_st> key;
};

/// The signing keys of a JWK set. Keys of other kinds, for encryption, too short (RSA below 2048
/// bits) or broken are left out: a provider may publish more than we need. kInvalid when `text` is
/// no JWK set.
core::Result<std::vector<Jwk>> ParseJwks(std::string_view text);

/// Does `signature` (as a JWS has it) of `key` stand under `text`?
bool Verifies(const Jwk& key, std::string_view text, std::string_view signature);

}  // namespace faultlab::server::oidc
