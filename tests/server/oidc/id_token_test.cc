#include "server/oidc/id_token.h"

#include <gmock/gmock.h>

#include <boost/json.hpp>
#include <limits>

#include "server/oidc/claims.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;
using testing::HasSubstr;

constexpr std::int64_t kNowS = 1'770'000'000;

ExpectedToken Expected() {
  return {"https://login.example", "faultlab", "n-1", "access", FromMilliseconds(kNowS * 1000)};
}

json::object Good() {
  return {{"iss", "https://login.example"},
          {"sub", "248289761001"},
          {"aud", "faultlab"},
          {"exp", kNowS + 300},
          {"iat", kNowS - 5},
          {"nonce", "n-1"}};
}

std::string Check(const std::string& name, const json::value& value) {
  json::object claims = Good();
  if (value.is_null()) claims.erase(name);
  if (!value.is_null()) claims[name] = value;
  const core::Status status = CheckIdToken(claims, Expected());
  return status.ok() ? "ok" : status.error().message;
}

TEST(IdToken, TheAnswerToOurQuestionIsTaken) {
  EXPECT_EQ(Check("more", "claims"), "ok");
  EXPECT_EQ(Check("aud", json::array{"faultlab"}), "ok");
  EXPECT_EQ(Check("azp", "faultlab"), "ok");
  EXPECT_EQ(Check("at_hash", json::value(HalfHash("access"))), "ok");
}

TEST(IdToken, AnotherIssuerIsRefusedByteForByte) {
  for (const json::value& iss : {json::value("https://login.example/"),
                                 json::value("https://LOGIN.example"),
                                 json::value("http://login.example"),
                                 json::value(nullptr),
                                 json::value(json::array{"https://login.example"})}) {
    EXPECT_THAT(Check("iss", iss), HasSubstr("issuer")) << iss;
  }
}

TEST(IdToken, ATokenForAnotherClientIsRefused) {
  for (const json::value& aud : {json::value("other"),
                                 json::value(nullptr),
                                 json::value(json::array{}),
                                 json::value(json::array{"other"}),
                                 json::value(json::array{"faultlab", "other"}),
                                 json::value(json::array{"faultlab", 7}),
                                 json::value("faultlab ")}) {
    EXPECT_THAT(Check("aud", aud), HasSubstr("another client")) << aud;
  }
  EXPECT_THAT(Check("azp", "other"), HasSubstr("another client"));
  EXPECT_THAT(Check("azp", 7), HasSubstr("another client"));
  json::object shared = Good();
  shared["aud"] = json::array{"other", "faultlab"};
  shared["azp"] = "faultlab";
  EXPECT_TRUE(CheckIdToken(shared, Expected()).ok());
  shared["azp"] = "other";
  EXPECT_FALSE(CheckIdToken(shared, Expected()).ok());
}

TEST(IdToken, TimesHaveAMinuteOfSkew) {
  EXPECT_EQ(Check("exp", kNowS - 59), "ok");
  EXPECT_THAT(Check("exp", kNowS - 60), HasSubstr("expired"));
  EXPECT_EQ(Check("iat", kNowS + 60), "ok");
  EXPECT_THAT(Check("iat", kNowS + 61), HasSubstr("future"));
  EXPECT_THAT(Check("iat", kNowS - 661), HasSubstr("too old"));
  EXPECT_EQ(Check("nbf", kNowS + 60), "ok");
  EXPECT_THAT(Check("nbf", kNowS + 61), HasSubstr("not valid yet"));
  EXPECT_EQ(Check("exp", static_cast<double>(kNowS) + 0.5), "ok");
  for (const json::value& wrong : {json::value(nullptr),
                                   json::value("1970000000"),
                                   json::value(true),
                                   json::value(std::numeric_limits<double>::infinity())}) {
    EXPECT_NE(Check("exp", wrong), "ok");
    EXPECT_NE(Check("iat", wrong), "ok");
  }
}

TEST(IdToken, AnAnswerToAnotherQuestionIsRefused) {
  for (const json::value& nonce :
       {json::value(nullptr), json::value("n-2"), json::value(""), json::value(1)}) {
    EXPECT_THAT(Check("nonce", nonce), HasSubstr("nonce"));
  }
  EXPECT_THAT(Check("sub", nullptr), HasSubstr("nobody"));
  EXPECT_THAT(Check("sub", ""), HasSubstr("nobody"));
  EXPECT_THAT(Check("sub", json::value(std::string(256, 'x'))), HasSubstr("nobody"));
  EXPECT_THAT(Check("at_hash", json::value(HalfHash("another"))), HasSubstr("access token"));
}

TEST(Admission, PeopleOfAVerifiedDomainComeIn) {
  AdmissionRules rules;
  rules.allowed_domains = {"uns.ac.rs", "FTN.uns.ac.rs"};
  const auto admitted = [&](const json::value& email, const json::value& verified) {
    json::object claims = Good();
    claims["email"] = email;
    claims["email_verified"] = verified;
    return Admit(claims, rules).ok();
  };
  EXPECT_TRUE(admitted("ann@uns.ac.rs", true));
  EXPECT_TRUE(admitted("ann@FTN.UNS.ac.rs", "true"));
  EXPECT_FALSE(admitted("ann@uns.ac.rs", false));
  EXPECT_FALSE(admitted("ann@uns.ac.rs", nullptr));
  for (const char* email : {"ann@evil-uns.ac.rs",
                            "ann@uns.ac.rs.evil.example",
                            "ann@x@uns.ac.rs",
                            "uns.ac.rs",
                            "ann@sub.uns.ac.rs",
                            ""}) {
    EXPECT_FALSE(admitted(email, true)) << email;
  }
}

TEST(Admission, ARequiredClaimIsAWordOrOneOfAList) {
  AdmissionRules rules;
  rules.required_claim = "affiliation=student";
  const auto admitted = [&](const json::value& value) {
    json::object claims = Good();
    if (!value.is_null()) claims["affiliation"] = value;
    return Admit(claims, rules).ok();
  };
  EXPECT_TRUE(admitted("student"));
  EXPECT_TRUE(admitted(json::array{"member", "student"}));
  EXPECT_FALSE(admitted("students"));
  EXPECT_FALSE(admitted(json::array{"member"}));
  EXPECT_FALSE(admitted(nullptr));
  EXPECT_FALSE(admitted(json::object{{"student", true}}));
}

TEST(Admission, AnUnverifiedAddressIsNoLogin) {
  AdmissionRules rules;
  rules.login_claim = "email";
  json::object claims = Good();
  claims["email"] = "ann@uns.ac.rs";
  EXPECT_EQ(Admit(claims, rules).value().login, "");
  claims["email_verified"] = true;
  EXPECT_EQ(Admit(claims, rules).value().login, "ann@uns.ac.rs");
}

}  // namespace
}  // namespace faultlab::server::oidc
