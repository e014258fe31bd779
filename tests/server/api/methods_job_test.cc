// Methods of the literature compared on one recording, as a job.
#include <gtest/gtest.h>

#include <algorithm>
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
    const json::object run = Ok(Call(ann_, "POST runs", body), 201);
    const std::string id = Id(run);
    application_->runs().Wait(id);
    return id;
  }
  tests::HttpAnswer Ask(const Person& who, const std::string& settings) {
    return Call(who, "POST jobs", R"({"runs":[{"methods":)" + settings + "}]}");
  }
  json::object Ended(const json::object& batch) {
    const std::string id = Id(batch.at("items").at(0));
    json::object job;
    EXPECT_TRUE(tests::Await([&] {
      job = Ok(Call(ann_, "GET jobs/" + id));
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

/// What is longer than 1000 samples, or 8 kB of text, is long here.
class LongJobsTest : public MethodsJobTest {
 protected:
  LongJobsTest() {
    config_.short_samples_max = 1000;
    config_.short_text_bytes_max = 8'000;
    Restart();
  }
  static std::string IdOf(const json::object& batch, std::size_t at = 0) {
    return Id(batch.at("items").at(at));
  }
  json::object Job(const Person& who, const std::string& id) {
    return Ok(Call(who, "GET jobs/" + id));
  }
  json::object Ended(const Person& who, const std::string& id) {
    json::object job;
    EXPECT_TRUE(tests::Await([&] {
      job = Job(who, id);
      return !job.at("ended_at").is_null();
    }));
    EXPECT_EQ(job.at("state"), "finished") << json::serialize(job);
    return job;
  }
  std::string RunOf(const Person& who, int seconds) {
    const json::object run =
        Ok(Call(who, "POST runs", R"({"duration_s":)" + std::to_string(seconds) + "}"), 201);
    const std::string id = Id(run);
    application_->runs().Wait(id);
    return id;
  }
  json::object Diagnose(const Person& who, const std::string& run) {
    return Ok(Call(who, "POST jobs", R"({"runs":[{"diagnose":{"recording":")" + run + "\"}}]}"),
              202);
  }
};

TEST_F(LongJobsTest, OfOneCallerStopNobodyElses) {
  const Person bob = Make("bob", Role::kStudent);
  const std::string long_run = RunOf(ann_, 40);
  const std::string short_run = RunOf(bob, 9);
  const std::string bobs_long_run = RunOf(bob, 12);
  std::string body;
  for (int i = 0; i < 16; ++i) {
    body += (i == 0 ? "" : ",") + (R"({"methods":{"recording":")" + long_run + "\"}}");
  }
  const json::object anns = Ok(Call(ann_, "POST jobs", R"({"runs":[)" + body + "]}"), 202);
  ASSERT_TRUE(tests::Await([&] { return !Job(ann_, IdOf(anns)).at("methods").is_null(); }));
  const std::string quick = IdOf(Diagnose(bob, short_run));
  const std::string slow = IdOf(Diagnose(bob, bobs_long_run));
  std::string csv = "t_s,um_v\n";
  for (int i = 0; i < 1000; ++i)
    csv += std::to_string(i) + "e-2,2." + std::to_string(i % 10) + "\n";
  const auto upload = [&] { return Call(bob, "POST recordings", csv, kCsv).status; };
  EXPECT_NE(upload(), 503) << "a long text of a person";
  Ended(bob, quick);
  const json::object slow_job = Ended(bob, slow);
  EXPECT_NE(upload(), 503);
  // Owners take turns: of those that were there before them, one for each of theirs may be done.
  std::size_t before = 0;
  for (std::size_t at = 0; at < 16; ++at) {
    const json::value ended_at = Job(ann_, IdOf(anns, at)).at("ended_at");
    if (ended_at.is_string() && ended_at.as_string() < slow_job.at("ended_at").as_string())
      ++before;
  }
  EXPECT_LE(before, 3U);
  EXPECT_TRUE(tests::Await([&] {
    const json::object all = Ok(Call(ann_, "GET jobs?limit=100"));
    const json::array& items = all.at("items").as_array();
    return std::ranges::count(items, "running", [](const json::value& job) {
             return job.at("state").as_string();
           }) <= 1;
  })) << "a job that waits for the turn holds no place";
  for (int i = 0; i < 16; ++i) {
    (void)Call(ann_, "DELETE jobs/" + IdOf(anns, static_cast<std::size_t>(i)));
  }
}

TEST_F(LongJobsTest, OfTwoCallersGoOnInTurnsAndLoseNothing) {
  const Person bob = Make("bob", Role::kStudent);
  const std::string anns_run = Run(kFaulty);
  const std::string bobs_run = RunOf(bob, 14);
  const auto ask = [&](const Person& who, const std::string& run) {
    return IdOf(
        Ok(Ask(who, R"({"recording":")" + run + R"(","names":["ls","parity","ekf-bank"]})"), 202));
  };
  const std::string first = ask(ann_, anns_run);
  const std::string second = ask(bob, bobs_run);
  const json::object anns = Ended(ann_, first);
  const json::object bobs = Ended(bob, second);
  for (const json::object& job : {anns, bobs}) {
    const json::array& methods = job.at("methods").at("methods").as_array();
    ASSERT_EQ(methods.size(), 3u);
    EXPECT_EQ(methods[0].at("method"), "ls");
    EXPECT_EQ(methods[1].at("method"), "parity");
    EXPECT_EQ(methods[2].at("method"), "ekf-bank");
  }
}

}  // namespace
}  // namespace faultlab::server
