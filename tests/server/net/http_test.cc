#include "server/net/http.h"

#include <gtest/gtest.h>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

TEST(HttpRequest, FindsHeadersInAnyCase) {
  HttpRequest request;
  request.headers = {{"content-TYPE", "text/csv"}, {"Host", "localhost"}};
  EXPECT_EQ(request.Header("Content-Type"), "text/csv");
  EXPECT_EQ(request.Header("Accept"), "");
}

TEST(HttpRequest, DecodesQueryParameters) {
  HttpRequest request;
  request.query = "name=R1+%3D+100%20%CE%A9&limit=5&empty=&flag";
  EXPECT_EQ(request.Query("name"), "R1 = 100 Ω");
  EXPECT_EQ(request.Query("limit"), "5");
  EXPECT_EQ(request.Query("empty"), "");
  EXPECT_EQ(request.Query("flag"), "");
  EXPECT_EQ(request.Query("cursor"), std::nullopt);
}

TEST(HttpRequest, LeavesABrokenEscapeAsItWasSent) {
  HttpRequest request;
  request.query = "a=%zz&b=%4";
  EXPECT_EQ(request.Query("a"), "%zz");
  EXPECT_EQ(request.Query("b"), "%4");
}

TEST(HttpRequest, AsksOnlyForPathParametersThatThePatternHas) {
  HttpRequest request;
  request.path_parameters = {{"id", "run-1"}};
  EXPECT_EQ(request.PathParameter("id"), "run-1");
  EXPECT_THROW(request.PathParameter("figure"), core::ContractError);
}

TEST(PercentDecode, RefusesANulByte) {
  EXPECT_EQ(PercentDecode("a%00b", false), std::nullopt);
  EXPECT_EQ(PercentDecode("a%2Fb+c", false), "a/b+c");
}

TEST(Problem, IsProblemJsonWithEscapedText) {
  const HttpResponse response =
      Problem(400, "invalid", "Bad Request", "say \"R1\"\n", "/faults/0/component");
  EXPECT_EQ(response.status, 400);
  EXPECT_EQ(response.content_type, "application/problem+json");
  EXPECT_EQ(response.body,
            R"({"type":"/problems/invalid","title":"Bad Request","status":400,)"
            R"("detail":"say \"R1\"\u000a","field":"/faults/0/component","reason":"invalid"})");
}

}  // namespace
}  // namespace faultlab::server
