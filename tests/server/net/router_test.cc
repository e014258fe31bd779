#include "server/net/router.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

class RouterTest : public ::testing::Test {
 protected:
  void Add(HttpMethod method, const std::string& pattern) {
    router_.Add(
        {method, pattern, RunsOn::kInline, 0, [](const HttpRequest&) { return HttpResponse{}; }});
  }
  /// The pattern that matches the request, or "404", or "405 " and the allowed methods.
  std::string Find(HttpMethod method, std::string_view path) {
    request_ = {};
    request_.method = method;
    request_.path = path;
    const Router::Match match = router_.Find(request_);
    if (match.route != nullptr) return match.route->pattern;
    return match.allow.empty() ? "404" : "405 " + match.allow;
  }

  Router router_;
  HttpRequest request_;
};

TEST_F(RouterTest, PrefersLiteralsToNamesAndNamesToTheRest) {
  Add(HttpMethod::kGet, "/*");
  Add(HttpMethod::kGet, "/runs/{id}");
  Add(HttpMethod::kGet, "/runs/latest");
  EXPECT_EQ(Find(HttpMethod::kGet, "/runs/latest"), "/runs/latest");
  EXPECT_EQ(Find(HttpMethod::kGet, "/runs/7"), "/runs/{id}");
  EXPECT_EQ(Find(HttpMethod::kGet, "/runs/7/more"), "/*");
  EXPECT_EQ(Find(HttpMethod::kGet, "/"), "/*");
}

TEST_F(RouterTest, GivesNamesTheirDecodedValues) {
  Add(HttpMethod::kGet, "/runs/{id}/plots/{figure}.png");
  EXPECT_EQ(Find(HttpMethod::kGet, "/runs/a%20b/plots/swa.png"), "/runs/{id}/plots/{figure}.png");
  EXPECT_EQ(request_.PathParameter("id"), "a b");
  EXPECT_EQ(request_.PathParameter("figure"), "swa");
  EXPECT_EQ(Find(HttpMethod::kGet, "/runs/1/plots/.png"), "404");
  EXPECT_EQ(Find(HttpMethod::kGet, "/runs/1/plots/swa.jpg"), "404");
  EXPECT_EQ(Find(HttpMethod::kGet, "/runs/%zz/plots/swa.png"), "404");
}

TEST_F(RouterTest, AnswersHeadByGetAndNamesTheAllowedMethods) {
  Add(HttpMethod::kGet, "/runs");
  Add(HttpMethod::kPost, "/runs");
  Add(HttpMethod::kGet, "/runs/{id}");
  Add(HttpMethod::kGet, "/*");
  EXPECT_EQ(Find(HttpMethod::kHead, "/runs"), "/runs");
  EXPECT_EQ(Find(HttpMethod::kDelete, "/runs"), "405 GET, HEAD, POST");
  EXPECT_EQ(Find(HttpMethod::kPut, "/runs/1"), "405 GET, HEAD");
  EXPECT_EQ(Find(HttpMethod::kPost, "/nowhere"), "404");
}

TEST_F(RouterTest, TakesNoPathWithoutSlashInFront) {
  Add(HttpMethod::kGet, "/*");
  EXPECT_EQ(Find(HttpMethod::kGet, ""), "404");
  EXPECT_EQ(Find(HttpMethod::kGet, "*"), "404");
}

TEST_F(RouterTest, TellsALongerPathFromAShorterOne) {
  Add(HttpMethod::kGet, "/a/{x}");
  EXPECT_EQ(Find(HttpMethod::kGet, "/a"), "404");
  EXPECT_EQ(Find(HttpMethod::kGet, "/a/"), "404");
  EXPECT_EQ(Find(HttpMethod::kGet, "/a/b/"), "404");
}

}  // namespace
}  // namespace faultlab::server
