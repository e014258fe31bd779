// Methods of the literature compared on one recording, as a job.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <string>

#include "core/methods/method_list.h"
#include "tests/server/api/api_world.h"
#include "tests/support/await.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class MethodsJobTest : public ApiTest {
 protected:
  std::string Run(const std::string& body) {
    const json::object run = Ok(Call(ann_, "POST", "runs", "runs", body), 201);
    const std::string id(run.at("id").as_string());
    application_->runs().Wait(id);
    return id;
  }
  tests::HttpAnswer Ask(const Person& who, const std::string& settings) {
    return Call(who, "POST", "jobs", "jobs", R"({"runs":[{"methods":)" + settings + "}]}");
  }
  json::object Ended(const json::object& batch) {
    const std::string id(batch.at("items").at(0).at("id").as_string());
    json::object job;
    EXPECT_TRUE(tests::Await([&] {
      job = Ok(Call(ann_, "GET", "jobs/{id}", "jobs/" + id));
      return job.at("state") != "waiting" && job.at("state") != "running";
    }));
    return job;
  }

  Person ann_ = Make("ann", Role::kStudent);
};

constexpr char kFaulty[] =
    R"({"rig":"sim-1","duration_s":14,"faults":[{"component":"R1","value":56,"at_s":8}]})";

TEST_F(MethodsJobTest, AllThatFitAnswerInTheOrderOfTheirList) {
  const std::string run = Run(kFaulty);
  const json::object job = Ended(Ok(Ask(ann_, R"({"recording":")" + run + "\"}"), 202));
  ASSERT_EQ(job.at("state"), "finished") << json::serialize(job);
  EXPECT_EQ(job.at("progress"), 1.0);
  EXPECT_EQ(job.at("recording").as_string(), run);
  EXPECT_TRUE(job.at("diagnosis").is_null());
  const json::array& methods = job.at("methods").at("methods").as_array();
  ASSERT_EQ(methods.size(), core::AllMethods().size());
  EXPECT_EQ(job.at("methods").at("of"), methods.size());
  for (std::size_t i = 0; i < methods.size(); ++i) {
    EXPECT_EQ(methods[i].at("method").as_string(), core::AllMethods()[i].name);
  }
  const json::value& own = methods.back();
  EXPECT_NEAR(own.at("detected_at_s").to_number<double>(), 8.0, 0.1);
  const json::value& last = own.at("looks").as_array().back();
  ASSERT_EQ(last.at("answer").as_array().size(), 1u);
  EXPECT_EQ(last.at("answer").at(0).at("component"), "R1");
  EXPECT_NEAR(last.at("answer").at(0).at("value").to_number<double>(), 56.0, 2.0);
}

TEST_F(MethodsJobTest, SomeOfThemAndAHealthyStretchOfOnesOwn) {
  const std::string run = Run(kFaulty);
  const json::object job = Ended(Ok(Ask(ann_,
                                        R"({"recording":")" + run +
                                            R"(","names":["parity","ekf-bank"],"channels":"all",
                                                "healthy_from_s":1,"healthy_to_s":6})"),
                                    202));
  ASSERT_EQ(job.at("state"), "finished") << json::serialize(job);
  const json::value& found = job.at("methods");
  EXPECT_EQ(found.at("healthy_to_s"), 6.0);
  ASSERT_EQ(found.at("methods").as_array().size(), 2u);
  EXPECT_EQ(found.at("methods").at(0).at("method"), "parity");
  EXPECT_EQ(found.at("methods").at(0).at("looks").at(0).at("identification"), "cannot");
}

TEST_F(MethodsJobTest, WhatCannotBeComparedIsRefusedOrSaysWhyItFailed) {
  const std::string run = Run(kFaulty);
  const tests::HttpAnswer unknown =
      Ask(ann_, R"({"recording":")" + run + R"(","names":["ls","magic"]})");
  EXPECT_EQ(unknown.status, 400);
  EXPECT_EQ(json::parse(unknown.body).at("field"), "/runs/0/methods/names/1");
  EXPECT_NE(unknown.body.find("ekf-bank"), std::string::npos) << "it names those that there are";
  EXPECT_EQ(Ask(ann_, R"({"recording":"run-none"})").status, 404);
  const Person bob = Make("bob", Role::kStudent);
  EXPECT_EQ(Ask(bob, R"({"recording":")" + run + "\"}").status, 404);

  const std::string brief = Run(R"({"rig":"sim-1","duration_s":3})");
  const json::object job = Ended(Ok(Ask(ann_, R"({"recording":")" + brief + "\"}"), 202));
  EXPECT_EQ(job.at("state"), "failed");
  EXPECT_FALSE(job.at("error").as_string().empty());
  EXPECT_TRUE(job.at("methods").is_null());
}

}  // namespace
}  // namespace faultlab::server
