// Windows and orders over a recording, by REST.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <string>
#include <utility>

#include "tests/server/api/api_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class StudyApiTest : public ApiTest {
 protected:
  std::string Played() {
    const std::string body =
        R"({"rig":"sim-1","seed":7,"duration_s":16,"faults":[{"component":"R1","value":10,"at_s":9}]})";
    std::string id(Ok(Call(kNobody, "POST runs", body), 201).at("id").as_string());
    application_->runs().Wait(id);
    return id;
  }
  json::object Study(const std::string& id, const std::string& query, int status = 200) {
    return Ok(Call(kNobody, "GET runs/" + id + "/study" + query), status);
  }
};

TEST_F(StudyApiTest, EachWindowIsStudiedInEachOrderAboutTheRunsOwnChange) {
  const std::string id = Played();
  const json::object six = Study(id, "");
  EXPECT_EQ(six.at("variants").as_array().size(), 6U);
  EXPECT_NEAR(six.at("change_s").to_number<double>(), 9.0, 0.02) << "as the rig has said it";
  const json::object orders = Study(id, "?k=100&km=100:20&order=1,2,3,4");
  ASSERT_EQ(orders.at("variants").as_array().size(), 8U);
  for (const json::value& variant : orders.at("variants").as_array()) {
    EXPECT_GT(variant.at("left").at("before").at("count").to_number<int>(), 500);
    EXPECT_FALSE(variant.at("left").at("after").is_null());
  }
  const json::object none = Study(id, "?km=&change=none");
  EXPECT_TRUE(none.at("change_s").is_null());
  EXPECT_TRUE(none.at("variants").at(0).at("left").at("after").is_null());
}

TEST_F(StudyApiTest, WhatCannotBeStudiedIsRefusedByName) {
  const std::string id = Played();
  const std::pair<const char*, const char*> cases[] = {{"?order=0", "order"},
                                                       {"?order=5", "order"},
                                                       {"?order=", "order"},
                                                       {"?k=&km=", "k"},
                                                       {"?k=x", "k"},
                                                       {"?km=20", "km"},
                                                       {"?k=5000&km=", "k"},
                                                       {"?k=3&km=", "k"},
                                                       {"?change=soon", "change"},
                                                       {"?change=0", "change"},
                                                       {"?change=nan", "change"},
                                                       {"?from_s=-1", "from_s"},
                                                       {"?exact=1", "exact"},
                                                       {"?exact=true&order=2", "exact"},
                                                       {"?windows=5", "windows"}};
  for (const auto& [query, field] : cases) {
    EXPECT_EQ(Study(id, query, 400).at("field"), field) << query;
  }
}

}  // namespace
}  // namespace faultlab::server
