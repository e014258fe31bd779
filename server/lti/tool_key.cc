#include "server/lti/tool_key.h"

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rsa.h>

#include <boost/json.hpp>
#include <vector>

#include "core/types/check.h"
#include "server/oidc/base64url.h"
#include "server/storage/ids.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server::lti {
namespace {

namespace json = boost::json;
using Key = std::shared_ptr<EVP_PKEY>;

constexpr unsigned kBits = 2048;

struct KeyRow {
  std::int64_t id = 1;
  std::string kid;
  std::string pem;
  WallTime created{};
};

template <typename Visit>
void Fields(KeyRow& row, Visit&& visit) {
  visit("id", row.id);
  visit("kid", row.kid);
  visit("pem", row.pem);
  visit("created_ms", row.created);
}

std::string PemOf(EVP_PKEY* key) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> bio(BIO_new(BIO_s_mem()), BIO_free);
  LAB_CHECK(PEM_write_bio_PrivateKey(bio.get(), key, nullptr, nullptr, 0, nullptr, nullptr) == 1);
  char* text = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &text);
  return {text, static_cast<std::size_t>(size)};
}

Key KeyOf(const std::string& pem) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> bio(
      BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free);
  return {PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, nullptr), EVP_PKEY_free};
}

/// A number of the key, big-endian, in base64url.
std::string Number(EVP_PKEY* key, const char* name) {
  BIGNUM* number = nullptr;
  LAB_CHECK(EVP_PKEY_get_bn_param(key, name, &number) == 1);
  std::string bytes(static_cast<std::size_t>(BN_num_bytes(number)), '\0');
  BN_bn2bin(number, reinterpret_cast<unsigned char*>(bytes.data()));
  BN_free(number);
  return oidc::EncodeBase64Url(bytes);
}

}  // namespace

core::Result<ToolKey> ToolKey::Open(Database& database, WallTime now) {
  TRY(const auto row, database.Write(Durability::kPromise, [&](Transaction& tx) {
    TakeTurn(tx, "lti_key");
    if (auto known = SelectRow<KeyRow>(tx, "lti_key WHERE id = 1")) return std::move(*known);
    const Key made(EVP_RSA_gen(kBits), EVP_PKEY_free);
    KeyRow fresh;
    fresh.kid = NewId("key");
    fresh.pem = PemOf(made.get());
    fresh.created = now;
    PutRow(tx, "lti_key", fresh);
    return fresh;
  }));
  Key key = KeyOf(row.pem);
  if (!key) {
    return core::Error{core::ErrorCode::kInvalid, "the key for learning platforms is damaged", ""};
  }
  return ToolKey(row.kid, std::move(key));
}

std::string ToolKey::KeySet() const {
  const json::object key{{"kty", "RSA"},
                         {"use", "sig"},
                         {"alg", "RS256"},
                         {"kid", kid_},
                         {"n", Number(key_.get(), OSSL_PKEY_PARAM_RSA_N)},
                         {"e", Number(key_.get(), OSSL_PKEY_PARAM_RSA_E)}};
  return json::serialize(json::object{{"keys", json::array{key}}});
}

std::string ToolKey::Sign(const json::object& claims) const {
  const json::object header{{"alg", "RS256"}, {"typ", "JWT"}, {"kid", kid_}};
  const std::string text = oidc::EncodeBase64Url(json::serialize(header)) + "." +
                           oidc::EncodeBase64Url(json::serialize(claims));
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
  return text + "." + oidc::EncodeBase64Url(signature);
}

}  // namespace faultlab::server::lti
