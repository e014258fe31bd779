#include "server/oidc/jwk.h"

#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ec.h>
#include <openssl/ecdsa.h>
#include <openssl/evp.h>
#include <openssl/param_build.h>
#include <openssl/x509.h>

#include <boost/json.hpp>

#include "server/oidc/base64url.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;

constexpr int kRsaBitsMin = 2048;
constexpr int kRsaBitsMax = 8192;  // longer keys would only take time
constexpr std::size_t kKeysMax = 64;
constexpr std::size_t kP256Bytes = 32;

template <auto Free>
struct Freed {
  template <typename T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Number = std::unique_ptr<BIGNUM, Freed<BN_free>>;
using Builder = std::unique_ptr<OSSL_PARAM_BLD, Freed<OSSL_PARAM_BLD_free>>;
using Parameters = std::unique_ptr<OSSL_PARAM, Freed<OSSL_PARAM_free>>;
using KeyContext = std::unique_ptr<EVP_PKEY_CTX, Freed<EVP_PKEY_CTX_free>>;
using DigestContext = std::unique_ptr<EVP_MD_CTX, Freed<EVP_MD_CTX_free>>;
using Signature = std::unique_ptr<ECDSA_SIG, Freed<ECDSA_SIG_free>>;

const unsigned char* Bytes(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

std::string Text(const json::object& object, std::string_view name) {
  const json::value* value = object.if_contains(name);
  return value != nullptr && value->is_string() ? std::string(value->get_string()) : "";
}

std::shared_ptr<EVP_PKEY> FromParameters(const char* type, OSSL_PARAM* parameters) {
  const KeyContext context(EVP_PKEY_CTX_new_from_name(nullptr, type, nullptr));
  EVP_PKEY* key = nullptr;
  const bool made = context && parameters != nullptr &&
                    EVP_PKEY_fromdata_init(context.get()) == 1 &&
                    EVP_PKEY_fromdata(context.get(), &key, EVP_PKEY_PUBLIC_KEY, parameters) == 1;
  return {made ? key : nullptr, EVP_PKEY_free};
}

std::shared_ptr<EVP_PKEY> RsaKey(const json::object& jwk) {
  const auto n = DecodeBase64Url(Text(jwk, "n"));
  const auto e = DecodeBase64Url(Text(jwk, "e"));
  if (!n || !e || n->size() > kRsaBitsMax / 8 + 1 || e->empty() || e->size() > 4) return nullptr;
  const Number modulus(BN_bin2bn(Bytes(*n), static_cast<int>(n->size()), nullptr));
  const Number exponent(BN_bin2bn(Bytes(*e), static_cast<int>(e->size()), nullptr));
  const Builder builder(OSSL_PARAM_BLD_new());
  if (!modulus || !exponent || !builder) return nullptr;
  const int bits = BN_num_bits(modulus.get());
  const bool good = bits >= kRsaBitsMin && bits <= kRsaBitsMax && BN_is_odd(exponent.get()) == 1 &&
                    BN_is_one(exponent.get()) == 0;
  if (!good) return nullptr;
  OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_N, modulus.get());
  OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_E, exponent.get());
  const Parameters parameters(OSSL_PARAM_BLD_to_param(builder.get()));
  return FromParameters("RSA", parameters.get());
}

std::shared_ptr<EVP_PKEY> P256Key(const json::object& jwk) {
  const auto x = DecodeBase64Url(Text(jwk, "x"));
  const auto y = DecodeBase64Url(Text(jwk, "y"));
  const bool right =
      Text(jwk, "crv") == "P-256" && x && y && x->size() == kP256Bytes && y->size() == kP256Bytes;
  if (!right) return nullptr;
  const std::string point = "\x04" + *x + *y;
  const Builder builder(OSSL_PARAM_BLD_new());
  if (!builder) return nullptr;
  OSSL_PARAM_BLD_push_utf8_string(builder.get(), OSSL_PKEY_PARAM_GROUP_NAME, "P-256", 0);
  OSSL_PARAM_BLD_push_octet_string(
      builder.get(), OSSL_PKEY_PARAM_PUB_KEY, point.data(), point.size());
  const Parameters parameters(OSSL_PARAM_BLD_to_param(builder.get()));
  auto key = FromParameters("EC", parameters.get());
  if (!key) return nullptr;
  const KeyContext check(EVP_PKEY_CTX_new_from_pkey(nullptr, key.get(), nullptr));
  if (!check || EVP_PKEY_public_check(check.get()) != 1) return nullptr;  // on the curve
  return key;
}

std::optional<Jwk> ParseKey(const json::value& value) {
  if (!value.is_object()) return std::nullopt;
  const json::object& object = value.get_object();
  const std::string use = Text(object, "use");
  if (object.contains("use") && use != "sig") return std::nullopt;
  const std::string type = Text(object, "kty");
  Jwk out;
  out.kid = Text(object, "kid");
  if (type == "RSA") {
    out.kind = SignatureKind::kRs256;
    out.key = RsaKey(object);
  } else if (type == "EC") {
    out.kind = SignatureKind::kEs256;
    out.key = P256Key(object);
  }
  const bool other_alg =
      object.contains("alg") && ParseSignatureKind(Text(object, "alg")) != out.kind;
  if (!out.key || other_alg) return std::nullopt;
  return out;
}

/// r and s of a JWS as DER, which OpenSSL needs; empty if it is not two numbers of 32 bytes.
std::string EcdsaDer(std::string_view signature) {
  if (signature.size() != 2 * kP256Bytes) return {};
  Number r(BN_bin2bn(Bytes(signature), kP256Bytes, nullptr));
  Number s(BN_bin2bn(Bytes(signature) + kP256Bytes, kP256Bytes, nullptr));
  const Signature pair(ECDSA_SIG_new());
  if (!r || !s || !pair || ECDSA_SIG_set0(pair.get(), r.get(), s.get()) != 1) return {};
  (void)r.release();
  (void)s.release();
  unsigned char* der = nullptr;
  const int length = i2d_ECDSA_SIG(pair.get(), &der);
  if (length <= 0) return {};
  const std::string out(reinterpret_cast<const char*>(der), static_cast<std::size_t>(length));
  OPENSSL_free(der);
  return out;
}

}  // namespace

std::optional<SignatureKind> ParseSignatureKind(std::string_view alg) {
  if (alg == "RS256") return SignatureKind::kRs256;
  if (alg == "ES256") return SignatureKind::kEs256;
  return std::nullopt;
}

core::Result<std::vector<Jwk>> ParseJwks(std::string_view text) {
  json::error_code error;
  const json::value document = json::parse(text, error);
  const json::value* keys =
      !error && document.is_object() ? document.get_object().if_contains("keys") : nullptr;
  if (keys == nullptr || !keys->is_array()) {
    return core::Error{core::ErrorCode::kInvalid, "the provider's keys are no JWK set", ""};
  }
  std::vector<Jwk> out;
  for (const json::value& value : keys->get_array()) {
    if (auto key = ParseKey(value); key && out.size() < kKeysMax) out.push_back(std::move(*key));
  }
  return out;
}

bool Verifies(const Jwk& key, std::string_view text, std::string_view signature) {
  const std::string der = key.kind == SignatureKind::kEs256 ? EcdsaDer(signature) : std::string();
  const std::string_view bytes = key.kind == SignatureKind::kEs256 ? der : signature;
  if (bytes.empty()) return false;
  const DigestContext context(EVP_MD_CTX_new());
  return context &&
         EVP_DigestVerifyInit(context.get(), nullptr, EVP_sha256(), nullptr, key.key.get()) == 1 &&
         EVP_DigestVerify(context.get(), Bytes(bytes), bytes.size(), Bytes(text), text.size()) == 1;
}

}  // namespace faultlab::server::oidc
