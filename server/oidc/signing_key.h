#pragma once

#include <boost/json/object.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "core/types/result.h"

struct evp_pkey_st;

namespace faultlab::server::oidc {

/// A key of our own, RSA 2048, with which a token is signed (RS256). Immutable, thread-safe.
class SigningKey {
 public:
  static SigningKey Make();
  /// kInvalid: not what Pem() has written.
  static core::Result<SigningKey> Read(const std::string& pem);
  /// The secret itself.
  std::string Pem() const;

  /// The public half, as a JWK.
  boost::json::object PublicKey(std::string_view kid) const;
  /// A JSON Web Token of these claims.
  std::string Sign(const boost::json::object& claims, std::string_view kid) const;

 private:
  explicit SigningKey(std::shared_ptr<evp_pkey_st> key) : key_(std::move(key)) {}

  std::shared_ptr<evp_pkey_st> key_;
};

}  // namespace faultlab::server::oidc
