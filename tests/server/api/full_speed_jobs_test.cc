// Jobs on simulators, and answers that are waited for.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <sstream>
#include <thread>

#include "tests/server/api/api_world.h"
#include "tests/support/await.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

/// As installed: simulators play in real time, and a job does not.
class RealTimeJobs : public ApiTest {
 protected:
  RealTimeJobs() { PlayAtSpeed(1.0); }
  /// Somebody's request waits.
  bool Waits() const {
    const std::string text = tests::Get(application_->port(), "/metrics").body;
    return text.find("\nfaultlab_http_waits_open 1\n") != std::string::npos;
  }
};

TEST_F(RealTimeJobs, RunAsFastAsTheyCanAndOneCallWaitsForAllOfThem) {
  const Person ann = Make("ann", Role::kStudent);
  const Person bob = Make("bob", Role::kStudent);
  const std::string fault = R"("faults":[{"component":"R1","value":22000,"at_s":10}])";
  const json::object made = Ok(
      Call(ann,
           "POST jobs",
           R"({"name":"night","runs":[{"duration_s":300,)" + fault + R"(},{"duration_s":300}]})"),
      202);
  const std::string at = "jobs/batches/" + Text(made, "batch");
  // While real time would have played a minute of each.
  const json::object batch = Ok(Call(ann, "GET " + at + "?wait=60"));
  EXPECT_EQ(batch.at("finished"), 2) << json::serialize(batch);
  EXPECT_EQ(batch.at("count"), 2);
  EXPECT_FALSE(batch.at("ended_at").is_null());
  EXPECT_EQ(Call(bob, "GET " + at).status, 404);
  EXPECT_EQ(Call(bob, "DELETE " + at).status, 404);

  std::istringstream lines(Call(ann, "GET " + at + "/jobs.jsonl").body);
  std::vector<json::object> told;
  for (std::string line; std::getline(lines, line);) told.push_back(json::parse(line).as_object());
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].at("component"), "R1");
  EXPECT_EQ(told[0].at("named"), json::array{"R1"});
  EXPECT_EQ(told[1].at("state"), "finished");
  const json::object run = Ok(Call(ann, "GET runs/" + Text(told[0], "run")));
  EXPECT_EQ(run.at("samples"), 30'000);
}

TEST_F(RealTimeJobs, AllOfARequestAreCancelledByOneCall) {
  const Person ann = Make("ann", Role::kStudent);
  std::string runs;
  for (int i = 0; i < 200; ++i) runs += std::string(i > 0 ? "," : "") + R"({"duration_s":600})";
  const json::object made = Ok(Call(ann, "POST jobs", R"({"runs":[)" + runs + "]}"), 202);
  const std::string at = "jobs/batches/" + Text(made, "batch");
  EXPECT_EQ(Call(ann, "DELETE " + at).status, 204);
  const json::object batch = Ok(Call(ann, "GET " + at));
  EXPECT_EQ(batch.at("waiting"), 0);
  EXPECT_EQ(batch.at("running"), 0);
  EXPECT_TRUE(tests::Await([&] { return application_->runs().Running().empty(); }))
      << "what was claimed meanwhile is stopped";
  EXPECT_GT(batch.at("cancelled").as_int64(), 100);
  EXPECT_EQ(Call(ann, "DELETE " + at).status, 409);
}

TEST_F(RealTimeJobs, AWaitIsAtMostAMinuteAndEndsWithTheRightToAsk) {
  const Person ann = Make("ann", Role::kStudent);
  // Nobody plays a person's run faster than real time.
  const json::object run = Ok(Call(ann, "POST runs", R"({"duration_s":600})"), 201);
  const std::string at = "runs/" + Id(run);
  EXPECT_EQ(Call(ann, "GET " + at + "?wait=86400").status, 400);
  EXPECT_EQ(Call(ann, "GET " + at + "?wait=-1").status, 400);
  EXPECT_EQ(Call(ann, "GET rigs?wait=1").status, 400) << "it has no end";
  EXPECT_EQ(Ok(Call(ann, "GET " + at + "?wait=1")).at("state"), "running");
  // Once it waits, which the server counts.
  std::thread ends([&] {
    EXPECT_TRUE(tests::Await([&] { return Waits(); }));
    const auto account = accounts_->GetByLogin("ann").value();
    EXPECT_TRUE(accounts_->Change(account.id, account.version, {}, {}, /*disabled=*/true).ok());
  });
  EXPECT_EQ(Call(ann, "GET " + at + "?wait=60").status, 401);
  ends.join();
}

TEST_F(RealTimeJobs, WhoKnowsTheLastAnswerWaitsForAnother) {
  const Person ann = Make("ann", Role::kStudent);
  const tests::HttpAnswer none = Call(ann, "GET tickets");
  const std::string tag = "If-None-Match: " + none.Header("ETag") + "\r\n";
  const auto asked = std::chrono::steady_clock::now();
  EXPECT_EQ(Call(ann, "GET tickets?wait=1", "", tag).status, 304);
  EXPECT_GE(std::chrono::steady_clock::now() - asked, std::chrono::seconds(1));
  const json::object job = Ok(Call(ann, "POST jobs", R"({"runs":[{"duration_s":60}]})"), 202);
  const std::string id = Id(job.at("items").at(0));
  const tests::HttpAnswer ended = Call(ann, "GET jobs/" + id + "?wait=60");
  EXPECT_EQ(json::parse(ended.body).at("state"), "finished");
  // A server that stops does not wait for who waits.
  tests::RawClient waits(application_->port());
  EXPECT_TRUE(waits.Send("GET /api/v1/tickets?wait=60 HTTP/1.1\r\nHost: 127.0.0.1\r\n" +
                         ann.headers + tag + "\r\n"));
  EXPECT_TRUE(tests::Await([&] { return Waits(); }));
  Restart();
  EXPECT_TRUE(waits.WaitForClose()) << "it is closed like an idle one";
}

}  // namespace
}  // namespace faultlab::server
