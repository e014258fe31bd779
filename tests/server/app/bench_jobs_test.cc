// Jobs on rigs that need a session, and jobs that only diagnose, in a whole server over HTTP.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <thread>

#include "tests/system/contract/contract_world.h"

namespace faultlab::tests {
namespace {

namespace json = boost::json;

class BenchJobs : public testing::Test {
 protected:
  json::object Job(const std::string& id) {
    return world_.Expect(200, "ann", "GET", "jobs/{id}", {{"id", id}});
  }
  json::array Submit(const std::string& who, const std::string& body) {
    const json::object batch = world_.Expect(202, who, "POST", "jobs", {}, body);
    return batch.empty() ? json::array{} : batch.at("items").as_array();
  }
  static std::string IdOf(const json::value& object) {
    return std::string(object.at("id").as_string());
  }
  json::object Ended(const std::string& id) {
    json::object job = Job(id);
    for (int i = 0; i < 6000 && !Over(job); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      job = Job(id);
    }
    return job;
  }
  static bool Over(const json::object& job) {
    return job.at("state") != "waiting" && job.at("state") != "running";
  }
  std::string Ticket(const std::string& who) {
    const json::object asked =
        world_.Expect(201, who, "POST", "tickets", {}, R"({"rig_class":"bench"})");
    return std::to_string(asked.at("ticket").at("id").as_int64());
  }
  json::object Accepted(const std::string& who) {
    return world_.Expect(200, who, "POST", "tickets/{id}/accept", {{"id", Ticket(who)}}, "{}");
  }

  ContractWorld world_;
};

TEST_F(BenchJobs, RunInGapsInASessionOfTheirOwnAndGiveTheRigBackToItsCheck) {
  world_.WaitForBenches();
  const json::array jobs = Submit(
      "ann",
      R"({"name":"b","runs":[{"rig":"bench-1","duration_s":3,"name":"R1 10"},{"rig":"bench-2","duration_s":3}]})");
  ASSERT_EQ(jobs.size(), 2u);
  for (const json::value& asked : jobs) {
    const json::object job = Ended(IdOf(asked));
    EXPECT_EQ(job.at("state"), "finished") << json::serialize(job);
    const json::object run = world_.Expect(
        200, "ann", "GET", "runs/{id}", {{"id", std::string(job.at("run").as_string())}});
    EXPECT_TRUE(run.at("rig").as_string().starts_with("bench-"));
    EXPECT_EQ(run.at("samples").as_int64(), 300);
  }
  EXPECT_EQ(Job(IdOf(jobs[0])).at("run_name"), "R1 10");
  world_.WaitForBenches();
  EXPECT_TRUE(world_.Expect(200, "ann", "GET", "sessions").at("items").as_array().empty());
}

TEST_F(BenchJobs, WaitBehindPeopleAndAreNoWayToTheRigForTheirOwner) {
  world_.WaitForBenches();
  const json::object ann = Accepted("ann");
  const json::object bob = Accepted("bob");
  const std::string id = IdOf(Submit("ann", R"({"runs":[{"rig":"bench-1","duration_s":3}]})")[0]);
  // The job gets its ticket before the person asks; nevertheless the person is next.
  json::array tickets;
  for (int i = 0; i < 2000 && tickets.empty(); ++i) {
    tickets = world_.Expect(200, "ann", "GET", "tickets").at("items").as_array();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(tickets.size(), 1u);
  (void)Ticket("teacher");
  const json::object place = world_.Expect(200, "teacher", "GET", "tickets");
  EXPECT_EQ(place.at("items").at(0).at("place"), 1);
  EXPECT_EQ(Job(id).at("state"), "waiting");
  const auto end = [&](const std::string& who, const json::object& session) {
    world_.Expect(204,
                  who,
                  "POST",
                  "sessions/{id}/end",
                  {{"id", std::to_string(session.at("id").as_int64())}},
                  "{}");
  };
  end("bob", bob);
  end("ann", ann);
  EXPECT_EQ(Ended(id).at("state"), "finished");
}

TEST_F(BenchJobs, ACancelledOneLeavesTheQueue) {
  world_.WaitForBenches();
  (void)Accepted("ann");
  (void)Accepted("bob");
  const std::string id = IdOf(Submit("ann", R"({"runs":[{"rig":"bench-1","duration_s":3}]})")[0]);
  HttpAnswer answer;
  for (int i = 0; i < 2000 && answer.status != 204; ++i) {  // 409 while a worker holds it
    answer = world_.Call("ann", "DELETE", "/api/v1/jobs/{id}", "/api/v1/jobs/" + id);
  }
  EXPECT_EQ(answer.status, 204);
  EXPECT_EQ(Job(id).at("state"), "cancelled");
  EXPECT_TRUE(world_.Expect(200, "ann", "GET", "tickets").at("items").as_array().empty());
}

TEST_F(BenchJobs, ADiagnosisOfAnUploadIsAJobWithItsSettings) {
  std::string csv = "t_s,uc_v,um_v\n";
  for (int i = 0; i < 1200; ++i) {
    const double uc_v = (i * 7919 / 13) % 2 == 0 ? 2.0 : 3.0;
    csv += std::to_string(i * 0.01) + "," + std::to_string(uc_v) + "," +
           std::to_string(2.4 * uc_v) + "\n";
  }
  const json::object uploaded =
      world_.Expect(201, "ann", "POST", "recordings", {}, csv, "Content-Type: text/csv\r\n");
  const std::string recording = IdOf(uploaded);
  const auto body = [&](const std::string& settings) {
    return R"({"runs":[{"diagnose":{"recording":")" + recording + "\"" + settings + "}}]}";
  };
  const json::object job =
      Ended(IdOf(Submit("ann", body(R"(,"channels":"um","values":"table2")"))[0]));
  EXPECT_EQ(job.at("state"), "finished") << json::serialize(job);
  EXPECT_EQ(job.at("recording"), json::string(recording));
  EXPECT_EQ(job.at("diagnosis").at("samples"), 1200);
  EXPECT_TRUE(job.at("diagnosis").as_object().contains("verdict"));
  EXPECT_TRUE(job.at("run").is_null());
  const HttpAnswer foreign = world_.Call("bob", "POST", "/api/v1/jobs", "/api/v1/jobs", body(""));
  EXPECT_EQ(foreign.status, 404) << foreign.body;
  const HttpAnswer refused =
      world_.Call("ann", "POST", "/api/v1/jobs", "/api/v1/jobs", body(R"(,"healthy_from_s":9)"));
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(json::parse(refused.body).at("field"), "/runs/0/diagnose/healthy_to_s");
}

}  // namespace
}  // namespace faultlab::tests
