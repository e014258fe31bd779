#include "server/oidc/login_state.h"

#include <gmock/gmock.h>

namespace faultlab::server::oidc {
namespace {

using std::chrono::minutes;

constexpr WallTime kNow{std::chrono::milliseconds{1'770'000'000'000}};

LoginState State() {
  return {"uni", "s", "n", "v", "https://lab.example/cb", "/runs?x=1", 7, kNow};
}

TEST(LoginSeal, OpensWhatItClosedForTenMinutes) {
  const LoginSeal seal("secret");
  const std::string text = seal.Close(State());
  const auto opened = seal.Open(text, kNow + minutes(9));
  ASSERT_TRUE(opened.has_value());
  EXPECT_EQ(opened->provider, "uni");
  EXPECT_EQ(opened->state, "s");
  EXPECT_EQ(opened->nonce, "n");
  EXPECT_EQ(opened->verifier, "v");
  EXPECT_EQ(opened->redirect_uri, "https://lab.example/cb");
  EXPECT_EQ(opened->next, "/runs?x=1");
  EXPECT_EQ(opened->add_to, 7);
  EXPECT_FALSE(seal.Open(text, kNow + minutes(10)));
  EXPECT_FALSE(seal.Open(text, kNow - minutes(2))) << "of the future";
  EXPECT_EQ(text.find("lab.example"), std::string::npos) << "a browser cannot read it";
  EXPECT_NE(text, seal.Close(State()));
  EXPECT_TRUE(LoginSeal("secret").Open(text, kNow)) << "another server of the lab";
}

TEST(LoginSeal, OpensNothingElse) {
  const LoginSeal seal("secret");
  const std::string text = seal.Close(State());
  EXPECT_FALSE(LoginSeal("other").Open(text, kNow));
  for (std::size_t i = 0; i < text.size(); i += 7) {
    std::string changed = text;
    changed[i] = changed[i] == 'A' ? 'B' : 'A';
    EXPECT_FALSE(seal.Open(changed, kNow)) << i;
  }
  for (const std::string& wrong : {std::string(),
                                   std::string("x"),
                                   text.substr(0, 30),
                                   text + "AAAA",
                                   std::string(5000, 'A')}) {
    EXPECT_FALSE(seal.Open(wrong, kNow));
  }
}

TEST(PathHere, LeadsNowhereElse) {
  for (const char* good : {"/", "/my", "/runs/run-1?tab=x#y", "/a//b"})
    EXPECT_EQ(PathHere(good), good);
  for (const char* bad : {"",
                          "my",
                          "//evil.example",
                          "/\\evil.example",
                          "https://evil.example",
                          "/\t/evil.example",
                          "/a\r\nSet-Cookie: x=1",
                          "\\\\evil",
                          "javascript:alert(1)",
                          "/a\\..\\b",
                          "/\xc3\xa4"}) {
    EXPECT_EQ(PathHere(bad), "/my") << bad;
  }
  EXPECT_EQ(PathHere("/" + std::string(500, 'a')), "/my");
}

TEST(Pkce, TheChallengeIsThatOfTheStandard) {
  EXPECT_EQ(ChallengeOf("dBjftJeZ4CVP-mB92K27uhbUJU1p1r_wW1gFWFOEjXk"),
            "E9Melhoa2OwvFrEMTJguCHaoeK1t8URWbuGJSstw-cM")
      << "RFC 7636, appendix B";
  EXPECT_EQ(RandomText().size(), 43u);
  EXPECT_NE(RandomText(), RandomText());
}

}  // namespace
}  // namespace faultlab::server::oidc
