#include "server/api/security.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>
#include <sstream>

#include "server/api/routes.h"
#include "tests/support/paths.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::object Described() {
  std::ifstream file(tests::InSource("server/api/openapi.json"));
  std::stringstream text;
  text << file.rdbuf();
  return json::parse(WithSecurity(text.str())).as_object();
}

json::value SecurityOf(const json::object& document, const char* path, const char* method) {
  return document.at("paths").at(path).at(method).at("security");
}

TEST(Security, OfEachOperationIsThatOfItsRoute) {
  const json::object document = Described();
  const auto of = [&](const char* path, const char* method) {
    return json::serialize(SecurityOf(document, path, method));
  };
  const std::string session = R"({"session":[],"csrf":[]})";
  EXPECT_EQ(of("/api/v1/runs", "post"), R"([{},{"key":["runs:write"]},)" + session + "]");
  EXPECT_EQ(of("/api/v1/jobs", "get"), R"([{"key":["jobs"]},{"session":[]}])");
  EXPECT_EQ(of("/api/v1/users", "post"), R"([{"key":["people"]},)" + session + "]");
  EXPECT_EQ(of("/api/v1/webhooks", "post"), R"([{"key":["lab"]},)" + session + "]");
  EXPECT_EQ(of("/api/v1/courses/{id}/links", "post"), "[" + session + "]");
  EXPECT_EQ(of("/api/v1/lti/keys", "get"), "[]");
  EXPECT_EQ(of("/healthz", "get"), "[]");
}

TEST(Security, EachOperationSaysWhoMayAndWhatAKeyNeeds) {
  const json::object document = Described();
  const auto of = [&](const char* path, const char* method) {
    return std::string(document.at("paths").at(path).at(method).at("description").as_string());
  };
  EXPECT_EQ(of("/api/v1/bookings", "post"),
            "For students, instructors, operators and admins; operators and admins also for what "
            "is others'. A key needs the scope `lab`. Sent again with the same `Idempotency-Key` "
            "it gives the first answer.");
  EXPECT_EQ(of("/api/v1/lti/platforms", "get"), "For admins. Not by a key.");
  EXPECT_EQ(of("/healthz", "get"), "Needs no account.");
  EXPECT_NE(of("/api/v1/rig-classes/{rig_class}/hours", "get").find("\n\nFor everybody."),
            std::string::npos);
  for (const auto& [path, operations] : document.at("paths").as_object()) {
    for (const auto& [method, operation] : operations.as_object()) {
      const json::value* const text = operation.as_object().if_contains("description");
      EXPECT_TRUE(text != nullptr && !text->as_string().empty()) << method << " " << path;
    }
  }
}

TEST(Security, EveryRouteIsDescribedAndEveryOperationIsARoute) {
  const json::object document = Described();
  std::size_t routes = 0;
  for (const ApiTable table : ApiTables()) routes += table().size();
  std::size_t operations = 0;
  for (const auto& [path, methods] : document.at("paths").as_object()) {
    for (const auto& [method, operation] : methods.as_object()) {
      ++operations;
      EXPECT_TRUE(operation.as_object().contains("security")) << path << " " << method;
      for (const json::value& way : operation.at("security").as_array()) {
        for (const auto& [scheme, scopes] : way.as_object()) {
          EXPECT_TRUE(document.at("components").at("securitySchemes").as_object().contains(scheme));
        }
      }
    }
  }
  EXPECT_EQ(operations, routes);
}

}  // namespace
}  // namespace faultlab::server
