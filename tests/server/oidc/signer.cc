#include "tests/server/oidc/signer.h"

#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ecdsa.h>
#include <openssl/evp.h>
#include <openssl/pem.h>

#include <boost/json.hpp>

#include "server/oidc/base64url.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;

constexpr int kP256Bytes = 32;

std::string Number(const EVP_PKEY* key, const char* name, int bytes) {
  BIGNUM* number = nullptr;
  EVP_PKEY_get_bn_param(key, name, &number);
  if (bytes == 0) bytes = BN_num_bytes(number);
  std::string out(static_cast<std::size_t>(bytes), '\0');
  BN_bn2binpad(number, reinterpret_cast<unsigned char*>(out.data()), bytes);
  BN_free(number);
  return EncodeBase64Url(out);
}

}  // namespace

Signer::Signer(std::string kid, unsigned bits)
    : kid_(std::move(kid)),
      rsa_(bits != 0),
      key_(bits != 0 ? EVP_RSA_gen(bits) : EVP_EC_gen("P-256"), EVP_PKEY_free) {}

json::object Signer::Jwk() const {
  json::object out{{"kid", kid_}};
  if (rsa_) {
    out["kty"] = "RSA";
    out["n"] = Number(key_.get(), OSSL_PKEY_PARAM_RSA_N, 0);
    out["e"] = Number(key_.get(), OSSL_PKEY_PARAM_RSA_E, 0);
  } else {
    out["kty"] = "EC";
    out["crv"] = "P-256";
    out["x"] = Number(key_.get(), OSSL_PKEY_PARAM_EC_PUB_X, kP256Bytes);
    out["y"] = Number(key_.get(), OSSL_PKEY_PARAM_EC_PUB_Y, kP256Bytes);
  }
  return out;
}

std::string Signer::PublicPem() const {
  BIO* memory = BIO_new(BIO_s_mem());
  PEM_write_bio_PUBKEY(memory, key_.get());
  char* data = nullptr;
  const long length = BIO_get_mem_data(memory, &data);
  std::string out(data, static_cast<std::size_t>(length));
  BIO_free(memory);
  return out;
}

std::string Signer::Sign(const std::string& text) const {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  EVP_DigestSignInit(context, nullptr, EVP_sha256(), nullptr, key_.get());
  std::size_t length = 0;
  const auto* bytes = reinterpret_cast<const unsigned char*>(text.data());
  EVP_DigestSign(context, nullptr, &length, bytes, text.size());
  std::string out(length, '\0');
  auto* to = reinterpret_cast<unsigned char*>(out.data());
  EVP_DigestSign(context, to, &length, bytes, text.size());
  EVP_MD_CTX_free(context);
  out.resize(length);
  if (rsa_) return out;
  const unsigned char* at = to;
  ECDSA_SIG* pair = d2i_ECDSA_SIG(nullptr, &at, static_cast<long>(length));
  std::string raw(2 * kP256Bytes, '\0');
  auto* raw_bytes = reinterpret_cast<unsigned char*>(raw.data());
  BN_bn2binpad(ECDSA_SIG_get0_r(pair), raw_bytes, kP256Bytes);
  BN_bn2binpad(ECDSA_SIG_get0_s(pair), raw_bytes + kP256Bytes, kP256Bytes);
  ECDSA_SIG_free(pair);
  return raw;
}

json::object Signer::Header() const {
  return {{"alg", rsa_ ? "RS256" : "ES256"}, {"kid", kid_}, {"typ", "JWT"}};
}

std::string Signer::Token(const json::object& header, const json::object& claims) const {
  const std::string text = Unsigned(header, claims);
  return text + "." + EncodeBase64Url(Sign(text));
}

std::string Unsigned(const json::object& header, const json::object& claims) {
  return EncodeBase64Url(json::serialize(header)) + "." + EncodeBase64Url(json::serialize(claims));
}

}  // namespace faultlab::server::oidc
