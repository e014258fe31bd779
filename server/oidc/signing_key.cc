#include "server/oidc/signing_key.h"

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rsa.h>

#include <boost/json.hpp>

#include "core/types/check.h"
#include "server/oidc/base64url.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;
using Bio = std::unique_ptr<BIO, decltype(&BIO_free)>;

constexpr unsigned kBits = 2048;

/// A number of the key, big-endian, in base64url.
std::string NumberText(EVP_PKEY* key, const char* name) {
  BIGNUM* number = nullptr;
  LAB_CHECK(EVP_PKEY_get_bn_param(key, name, &number) == 1);
  std::string bytes(static_cast<std::size_t>(BN_num_bytes(number)), '\0');
  BN_bn2bin(number, reinterpret_cast<unsigned char*>(bytes.data()));
  BN_free(number);
  return EncodeBase64Url(bytes);
}

}  // namespace

SigningKey SigningKey::Make() {
  SigningKey made({EVP_RSA_gen(kBits), EVP_PKEY_free});
  LAB_CHECK(made.key_ != nullptr);
  return made;
}

core::Result<SigningKey> SigningKey::Read(const std::string& pem) {
  const Bio bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free);
  SigningKey read({PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, nullptr), EVP_PKEY_free});
  if (read.key_ == nullptr) {
    return core::Error{core::ErrorCode::kInvalid, "the signing key is damaged", ""};
  }
  return read;
}

std::string SigningKey::Pem() const {
  const Bio bio(BIO_new(BIO_s_mem()), BIO_free);
  LAB_CHECK(
      PEM_write_bio_PrivateKey(bio.get(), key_.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1);
  char* text = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &text);
  return {text, static_cast<std::size_t>(size)};
}

json::object SigningKey::PublicKey(std::string_view kid) const {
  return {{"kty", "RSA"},
          {"use", "sig"},
          {"alg", "RS256"},
          {"kid", kid},
          {"n", NumberText(key_.get(), OSSL_PKEY_PARAM_RSA_N)},
          {"e", NumberText(key_.get(), OSSL_PKEY_PARAM_RSA_E)}};
}

std::string SigningKey::Sign(const json::object& claims, std::string_view kid) const {
  const json::object header{{"alg", "RS256"}, {"typ", "JWT"}, {"kid", kid}};
  const std::string text =
      EncodeBase64Url(json::serialize(header)) + "." + EncodeBase64Url(json::serialize(claims));
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        EVP_MD_CTX_free);
  LAB_CHECK(EVP_DigestSignInit(context.get(), nullptr, EVP_sha256(), nullptr, key_.get()) == 1);
  const auto* bytes = reinterpret_cast<const unsigned char*>(text.data());
  std::size_t size = 0;
  LAB_CHECK(EVP_DigestSign(context.get(), nullptr, &size, bytes, text.size()) == 1);
  std::string signature(size, '\0');
  LAB_CHECK(EVP_DigestSign(context.get(),
                           reinterpret_cast<unsigned char*>(signature.data()),
                           &size,
                           bytes,
                           text.size()) == 1);
  signature.resize(size);
  return text + "." + EncodeBase64Url(signature);
}

}  // namespace faultlab::server::oidc
