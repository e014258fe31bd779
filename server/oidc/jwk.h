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

/// The accepted kinds of signatures; all others, in particular "none" and HS256, are refused.
enum class SignatureKind { kRs256, kEs256 };
std::optional<SignatureKind> ParseSignatureKind(std::string_view alg);

/// A public key of a provider. Valid for one kind of signature, whatever the token states.
struct Jwk {
  std::string kid;  ///< empty if the provider gives none
  SignatureKind kind = SignatureKind::kRs256;
  std::shared_ptr<evp_pkey_st> key;
};

/// The signing keys of a JWK set. Keys of other kinds, for encryption, too short (RSA below 2048
/// bits) or broken are left out, because a provider may publish more than is needed. kInvalid when
/// `text` is not a JWK set.
core::Result<std::vector<Jwk>> ParseJwks(std::string_view text);

/// Whether `signature` (in the form of a JWS) is a signature of `text` by `key`.
bool Verifies(const Jwk& key, std::string_view text, std::string_view signature);

}  // namespace faultlab::server::oidc
