#include "tests/support/json_schema.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>

namespace faultlab::tests {
namespace {

constexpr const char* kDescription = R"({
 "paths": {"/a": {"get": {"responses": {"200": {"content": {"application/json":
   {"schema": {"$ref": "#/components/schemas/A"}}}}}}}},
 "components": {"schemas": {
   "A": {"type": "object", "required": ["n"], "additionalProperties": false,
         "properties": {"n": {"type": "integer", "minimum": 1},
                        "list": {"type": "array", "minItems": 2, "items": {"type": ["number", "null"]}},
                        "word": {"enum": ["x", "y"]},
                        "kind": {"oneOf": [{"const": 1}, {"const": 2}]}}},
   "Odd": {"type": "object", "unheard": 1}}}})";

class JsonSchemaTest : public ::testing::Test {
 protected:
  bool Fits(const char* text) {
    return !description_.CheckAnswer("GET", "/a", 200, "application/json; charset=x", text);
  }
  ApiDescription description_{kDescription};
};

TEST(SharedParts, OfOperationsAreFollowed) {
  const ApiDescription description(R"({
   "paths": {"/a": {"get": {"parameters": [{"$ref": "#/components/parameters/Id"}],
                            "responses": {"404": {"$ref": "#/components/responses/NotFound"}}}}},
   "components": {
     "parameters": {"Id": {"name": "id", "in": "path"}},
     "responses": {"NotFound": {"description": "No such thing.", "content": {"application/json":
       {"schema": {"type": "integer"}}}}}}})");
  EXPECT_FALSE(description.CheckAnswer("GET", "/a", 404, "application/json", "1"));
  EXPECT_TRUE(description.CheckAnswer("GET", "/a", 404, "application/json", "true"));
  const boost::json::object& get =
      description.document().at("paths").at("/a").at("get").as_object();
  EXPECT_EQ(get.at("parameters").at(0).at("name"), "id");
}

TEST_F(JsonSchemaTest, AcceptsWhatFits) {
  EXPECT_TRUE(Fits(R"({"n":1,"list":[1,2.5,null],"word":"y","kind":2})"));
}

TEST_F(JsonSchemaTest, FindsEachKindOfMisfit) {
  EXPECT_FALSE(Fits(R"({})"));
  EXPECT_FALSE(Fits(R"({"n":0})"));
  EXPECT_FALSE(Fits(R"({"n":1.5})"));
  EXPECT_FALSE(Fits(R"({"n":1,"more":1})"));
  EXPECT_FALSE(Fits(R"({"n":1,"list":[1,"a"]})"));
  EXPECT_FALSE(Fits(R"({"n":1,"list":[1]})"));
  EXPECT_FALSE(Fits(R"({"n":1,"word":"z"})"));
  EXPECT_FALSE(Fits(R"({"n":1,"kind":3})"));
  EXPECT_FALSE(Fits("not json"));
}

TEST_F(JsonSchemaTest, FindsWhatIsNotDescribed) {
  EXPECT_TRUE(description_.CheckAnswer("POST", "/a", 200, "application/json", "{}"));
  EXPECT_TRUE(description_.CheckAnswer("GET", "/a", 404, "application/json", "{}"));
  EXPECT_TRUE(description_.CheckAnswer("GET", "/a", 200, "text/html", "{}"));
}

TEST_F(JsonSchemaTest, RefusesAKeywordThatItWouldIgnore) {
  const auto schema = boost::json::parse(R"({"$ref":"#/components/schemas/Odd"})");
  EXPECT_TRUE(description_.CheckSchema(boost::json::object{}, schema));
}

}  // namespace
}  // namespace faultlab::tests
