#include "server/oidc/jwt.h"

#include <gmock/gmock.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <array>
#include <boost/json.hpp>

#include "server/oidc/base64url.h"
#include "tests/server/oidc/signer.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;
using testing::HasSubstr;
using testing::SizeIs;

const Signer& Rsa() {
  static const Signer kSigner("rsa-1", 2048);
  return kSigner;
}
const Signer& Ec() {
  static const Signer kSigner("ec-1", 0);
  return kSigner;
}
const json::object kClaims{{"sub", "ann"}, {"iss", "https://login.example"}};

std::vector<Jwk> KeysOf(const json::array& keys) {
  return ParseJwks(json::serialize(json::object{{"keys", keys}})).value();
}

/// "ok", or the reason of the refusal.
std::string Check(const std::string& token, const std::vector<Jwk>& keys) {
  const auto apart = TakeApart(token);
  if (!apart) return apart.error().message;
  const Jwk* key = KeyOf(apart.value().header, keys);
  if (key == nullptr) return "no such key";
  const auto claims = Prove(apart.value(), *key);
  return claims.ok() ? "ok" : claims.error().message;
}

std::string Hs256(const std::string& text, const std::string& secret) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> mac{};
  unsigned length = 0;
  HMAC(EVP_sha256(),
       secret.data(),
       static_cast<int>(secret.size()),
       reinterpret_cast<const unsigned char*>(text.data()),
       text.size(),
       mac.data(),
       &length);
  return EncodeBase64Url({reinterpret_cast<const char*>(mac.data()), length});
}

TEST(Jwt, TokensOfTheProvidersKeysAreTaken) {
  const auto keys = KeysOf({Rsa().Jwk(), Ec().Jwk()});
  ASSERT_THAT(keys, SizeIs(2));
  EXPECT_EQ(Check(Rsa().Token(Rsa().Header(), kClaims), keys), "ok");
  EXPECT_EQ(Check(Ec().Token(Ec().Header(), kClaims), keys), "ok");
  const auto apart = TakeApart(Rsa().Token(Rsa().Header(), kClaims)).value();
  EXPECT_EQ(Prove(apart, keys[0]).value().at("sub"), "ann");
}

TEST(Jwt, ATokenWithoutASignatureOrWithASharedSecretIsRefused) {
  const auto keys = KeysOf({Rsa().Jwk()});
  const auto with_alg = [](const char* alg) {
    json::object header = Rsa().Header();
    header["alg"] = alg;
    return header;
  };
  EXPECT_THAT(Check(Unsigned(with_alg("none"), kClaims) + ".", keys), HasSubstr("not signed"));
  for (const char* alg :
       {"none", "None", "NONE", "", "HS256", "RS384", "PS256", "rs256", "RS256 "}) {
    EXPECT_THAT(Check(Rsa().Token(with_alg(alg), kClaims), keys), HasSubstr("not signed")) << alg;
  }
  json::object no_alg = Rsa().Header();
  no_alg.erase("alg");
  EXPECT_THAT(Check(Rsa().Token(no_alg, kClaims), keys), HasSubstr("not signed"));
  no_alg["alg"] = json::array{"RS256"};
  EXPECT_THAT(Check(Rsa().Token(no_alg, kClaims), keys), HasSubstr("not signed"));
  // The public key, which everybody knows, used as the secret of an HMAC.
  for (const std::string& secret : {Rsa().PublicPem(), json::serialize(Rsa().Jwk())}) {
    for (const char* alg : {"HS256", "RS256"}) {
      const std::string text = Unsigned(with_alg(alg), kClaims);
      EXPECT_NE(Check(text + "." + Hs256(text, secret), keys), "ok") << alg;
    }
  }
}

TEST(Jwt, AKeyIsGoodForItsOwnKindAlone) {
  const auto keys = KeysOf({Rsa().Jwk(), Ec().Jwk()});
  json::object header = Ec().Header();
  header["kid"] = "rsa-1";
  EXPECT_EQ(Check(Ec().Token(header, kClaims), keys), "no such key");
  header = Rsa().Header();
  header["kid"] = "ec-1";
  EXPECT_EQ(Check(Rsa().Token(header, kClaims), keys), "no such key");
  const auto apart = TakeApart(Rsa().Token(Rsa().Header(), kClaims)).value();
  EXPECT_FALSE(Prove(apart, keys[1]).ok());
}

TEST(Jwt, ASignatureOfAnotherKeyOrOfAnotherTextIsRefused) {
  const auto keys = KeysOf({Rsa().Jwk(), Ec().Jwk()});
  const Signer stranger("rsa-1", 2048);
  EXPECT_THAT(Check(stranger.Token(Rsa().Header(), kClaims), keys),
              HasSubstr("not the provider's"));
  for (const Signer* signer : {&Rsa(), &Ec()}) {
    const std::string good = signer->Token(signer->Header(), kClaims);
    const std::string signature = good.substr(good.rfind('.'));
    EXPECT_THAT(Check(Unsigned(signer->Header(), {{"sub", "admin"}}) + signature, keys),
                HasSubstr("not the provider's"));
    json::object header = signer->Header();
    header["typ"] = "other";
    EXPECT_THAT(Check(Unsigned(header, kClaims) + signature, keys),
                HasSubstr("not the provider's"));
    const std::string zeros(signature.size() - 1, 'A');
    EXPECT_THAT(Check(Unsigned(signer->Header(), kClaims) + "." + zeros, keys),
                HasSubstr("not the provider's"));
  }
}

TEST(Jwt, EveryOtherLastCharacterIsAnotherToken) {
  const auto keys = KeysOf({Rsa().Jwk()});
  const std::string good = Rsa().Token(Rsa().Header(), kClaims);
  ASSERT_EQ(Check(good, keys), "ok");
  for (const char c :
       std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_=+/")) {
    std::string other = good;
    if (other.back() == c) continue;
    other.back() = c;
    EXPECT_NE(Check(other, keys), "ok") << c;
  }
  for (const char* more : {"=", "==", " ", "\n", ".", ".e30", "A"}) {
    EXPECT_NE(Check(good + more, keys), "ok") << more;
  }
}

TEST(Jwt, WhatIsNoTokenIsRefused) {
  const auto keys = KeysOf({Rsa().Jwk()});
  const std::string good = Rsa().Token(Rsa().Header(), kClaims);
  for (const std::string& text : {std::string(),
                                  std::string("."),
                                  std::string(".."),
                                  std::string("a.b"),
                                  good + "." + good,
                                  good.substr(0, good.rfind('.') + 1),
                                  "bnVsbA." + good.substr(good.find('.') + 1),
                                  std::string(40 << 10, 'A')}) {
    EXPECT_NE(Check(text, keys), "ok") << text.substr(0, 60);
  }
  json::object header = Rsa().Header();
  header["crit"] = json::array{"exp"};
  EXPECT_THAT(Check(Rsa().Token(header, kClaims), keys), HasSubstr("crit"));
  header = Rsa().Header();
  header["kid"] = 7;
  EXPECT_THAT(Check(Rsa().Token(header, kClaims), keys), HasSubstr("kid"));
}

TEST(Jwt, AnUnknownOrAmbiguousKeyIsNone) {
  const std::string token = Rsa().Token(Rsa().Header(), kClaims);
  EXPECT_EQ(Check(token, {}), "no such key");
  json::object other = Rsa().Jwk();
  other["kid"] = "rsa-2";
  EXPECT_EQ(Check(token, KeysOf({other})), "no such key");
  json::object header = Rsa().Header();
  header.erase("kid");
  const std::string unnamed = Rsa().Token(header, kClaims);
  EXPECT_EQ(Check(unnamed, KeysOf({Rsa().Jwk(), Ec().Jwk()})), "ok") << "the only one of its kind";
  EXPECT_EQ(Check(unnamed, KeysOf({Rsa().Jwk(), other})), "no such key");
}

TEST(Jwks, KeysThatAreTooShortForOtherUseOrBrokenAreLeftOut) {
  EXPECT_TRUE(KeysOf({Signer("small", 1024).Jwk()}).empty());
  const auto changed = [](json::object key, const char* name, const json::value& value) {
    key[name] = value;
    return key;
  };
  for (const json::object& key : {changed(Rsa().Jwk(), "use", "enc"),
                                  changed(Rsa().Jwk(), "use", 1),
                                  changed(Rsa().Jwk(), "alg", "RS512"),
                                  changed(Rsa().Jwk(), "alg", "ES256"),
                                  changed(Rsa().Jwk(), "kty", "oct"),
                                  changed(Rsa().Jwk(), "e", "AQ"),
                                  changed(Rsa().Jwk(), "e", "Ag"),
                                  changed(Rsa().Jwk(), "n", "===="),
                                  changed(Ec().Jwk(), "crv", "P-384"),
                                  changed(Ec().Jwk(), "x", Ec().Jwk().at("y")),
                                  changed(Ec().Jwk(), "y", "AAAA")}) {
    EXPECT_TRUE(KeysOf({key}).empty()) << json::serialize(key);
  }
  EXPECT_THAT(KeysOf({changed(Rsa().Jwk(), "use", "sig"), changed(Ec().Jwk(), "alg", "ES256"), 3}),
              SizeIs(2));
  for (const char* text : {"", "[]", "{}", R"({"keys":{}})", "{\"keys\":[\xff]}"}) {
    EXPECT_FALSE(ParseJwks(text).ok()) << text;
  }
}

TEST(Base64Url, HasOneTextForEveryValue) {
  for (const std::string& bytes : {std::string(),
                                   std::string("f"),
                                   std::string("fo"),
                                   std::string("foo"),
                                   std::string("\0\xff\xfe", 3)}) {
    EXPECT_EQ(DecodeBase64Url(EncodeBase64Url(bytes)), bytes);
  }
  EXPECT_EQ(EncodeBase64Url("f"), "Zg");
  for (const char* text : {"Zh", "Zg==", "Zg=", "Z", "Zm9v\n", "Zm 9v", "+/8", "Zm9="}) {
    EXPECT_FALSE(DecodeBase64Url(text)) << text;
  }
}

}  // namespace
}  // namespace faultlab::server::oidc
