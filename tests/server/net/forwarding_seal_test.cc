#include "server/net/forwarding_seal.h"

#include <gtest/gtest.h>

#include <chrono>

namespace faultlab::server {
namespace {

using std::chrono::seconds;

constexpr WallTime kNow{std::chrono::milliseconds(1'767'225'600'000)};

HttpRequest Asked(HttpMethod method, std::string_view target) {
  HttpRequest request;
  request.method = method;
  request.target = target;
  return request;
}

TEST(ForwardingSeal, TellsTheReceiverWhoTheClientIs) {
  const ForwardingSeal a("secret", "a");
  const ForwardingSeal b("secret", "b");
  const HttpRequest request = Asked(HttpMethod::kPost, "/api/v1/runs");
  const auto hop = b.Open(a.Seal({"2001:db8::1", true}, "b", request, kNow), request, kNow);
  ASSERT_TRUE(hop);
  EXPECT_EQ(hop->client, "2001:db8::1");
  EXPECT_TRUE(hop->https);
  // A proxy may state any text as the client.
  const auto odd = b.Open(a.Seal({"a b", false}, "b", request, kNow), request, kNow);
  ASSERT_TRUE(odd);
  EXPECT_EQ(odd->client, "a b");
  EXPECT_FALSE(odd->https);
}

TEST(ForwardingSeal, OpensNothingElse) {
  const ForwardingSeal a("secret", "a");
  const ForwardingSeal b("secret", "b");
  const HttpRequest request = Asked(HttpMethod::kPost, "/api/v1/runs");
  const std::string sealed = a.Seal({"10.0.0.9", false}, "b", request, kNow);

  EXPECT_FALSE(a.Open(sealed, request, kNow)) << "another receiver";
  EXPECT_FALSE(ForwardingSeal("other", "b").Open(sealed, request, kNow)) << "another lab";
  EXPECT_FALSE(b.Open(sealed, Asked(HttpMethod::kDelete, "/api/v1/runs"), kNow));
  EXPECT_FALSE(b.Open(sealed, Asked(HttpMethod::kPost, "/api/v1/runs?x"), kNow));
  EXPECT_FALSE(b.Open(sealed, request, kNow + seconds(11))) << "too old";
  EXPECT_FALSE(b.Open(sealed, request, kNow - seconds(11))) << "from the future";
  for (std::size_t i = 0; i < sealed.size(); ++i) {
    std::string changed = sealed;
    changed[i] = changed[i] == '1' ? '2' : '1';
    EXPECT_FALSE(b.Open(changed, request, kNow)) << changed;
  }
  for (const char* text : {"", " ", "1", "1 http", "1 http 00 127.0.0.1", "   ", "x http  y"}) {
    EXPECT_FALSE(b.Open(text, request, kNow)) << text;
  }
  EXPECT_TRUE(b.Open(sealed, request, kNow)) << "none of those was taken for it";
  EXPECT_FALSE(b.Open(sealed, request, kNow)) << "somebody has listened, and says it again";
  EXPECT_TRUE(b.Open(a.Seal({"10.0.0.9", false}, "b", request, kNow), request, kNow));
}

TEST(ForwardingSeal, CoversTheBody) {
  const ForwardingSeal a("secret", "a");
  const ForwardingSeal b("secret", "b");
  HttpRequest request = Asked(HttpMethod::kPost, "/api/v1/runs");
  request.body = R"({"duration_s":3})";
  const std::string sealed = a.Seal({"10.0.0.9", false}, "b", request, kNow);
  EXPECT_EQ(b.Open(sealed, request, kNow)->body_hash, BodyHash(request.body));
  EXPECT_NE(BodyHash(request.body), BodyHash(R"({"duration_s":4})"));
}

}  // namespace
}  // namespace faultlab::server
