#pragma once

#include <boost/json/object.hpp>
#include <memory>
#include <string>

struct evp_pkey_st;

namespace faultlab::server::oidc {

/// A provider's key pair, made for a test, and tokens signed by it.
class Signer {
 public:
  /// RSA if `bits` is not 0, otherwise P-256.
  Signer(std::string kid, unsigned bits);

  boost::json::object Jwk() const;
  std::string PublicPem() const;
  std::string Sign(const std::string& text) const;
  /// A token with exactly this header and these claims.
  std::string Token(const boost::json::object& header, const boost::json::object& claims) const;
  boost::json::object Header() const;

 private:
  std::string kid_;
  bool rsa_;
  std::shared_ptr<evp_pkey_st> key_;
};

/// header.payload of a token.
std::string Unsigned(const boost::json::object& header, const boost::json::object& claims);

}  // namespace faultlab::server::oidc
