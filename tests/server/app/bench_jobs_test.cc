// Jobs on rigs that need a session, and jobs that only diagnose, in a whole server over HTTP.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <thread>

#include "tests/support/await.h"
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
    EXPECT_TRUE(tests::Await([&] {
      if (!Over(job)) job = Job(id);
      return Over(job);
    }));
    return job;
  }
  /// The run of a job that is in progress.
  std::string RunOf(const std::string& id) {
    json::object job = Job(id);
    EXPECT_TRUE(tests::Await([&] {
      if (job.at("run").is_null()) job = Job(id);
      return !job.at("run").is_null();
    }));
    return job.at("run").is_null() ? "" : std::string(job.at("run").as_string());
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
  EXPECT_TRUE(tests::Await([&] {
    tickets = world_.Expect(200, "ann", "GET", "tickets").at("items").as_array();
    return !tickets.empty();
  }));
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
  const auto tickets = [&] {
    return world_.Expect(200, "ann", "GET", "tickets").at("items").as_array().size();
  };
  const std::string id = IdOf(Submit("ann", R"({"runs":[{"rig":"bench-1","duration_s":3}]})")[0]);
  ASSERT_TRUE(tests::Await([&] { return tickets() == 1; }));
  world_.Expect(204, "ann", "DELETE", "jobs/{id}", {{"id", id}});
  EXPECT_EQ(Job(id).at("state"), "cancelled");
  EXPECT_EQ(tickets(), 0U);
  // The next is cancelled at once, perhaps while it is given its place: only the last one waits.
  const std::string next = IdOf(Submit("ann", R"({"runs":[{"rig":"bench-1","duration_s":3}]})")[0]);
  world_.Expect(204, "ann", "DELETE", "jobs/{id}", {{"id", next}});
  (void)Submit("ann", R"({"runs":[{"rig":"bench-1","duration_s":3}]})");
  EXPECT_TRUE(tests::Await([&] { return tickets() == 1; }));
}

TEST_F(BenchJobs, LeaveThePlacesToOthersWhileTheyWait) {
  world_.WaitForBenches();
  (void)Accepted("ann");
  (void)Accepted("bob");
  std::string runs;
  for (int i = 0; i < 8; ++i) runs += R"({"rig":"bench-1","duration_s":3},)";
  (void)Submit("ann", R"({"runs":[)" + runs + R"({"rig":"bench-2","duration_s":3}]})");
  const std::string id = IdOf(Submit("ann", R"({"runs":[{"duration_s":3}]})")[0]);
  EXPECT_EQ(Ended(id).at("state"), "finished");
  const json::array all = world_.Expect(200, "ann", "GET", "jobs").at("items").as_array();
  for (const json::value& job : all) {
    EXPECT_EQ(job.at("state"), IdOf(job) == id ? "finished" : "waiting");
  }
}

TEST_F(BenchJobs, ARunningOneIsCancelledWithTheScopeOfJobsAlone) {
  const json::object batch =
      world_.Expect(202, "sender", "POST", "jobs", {}, R"({"runs":[{"duration_s":600}]})");
  const std::string id = IdOf(batch.at("items").at(0));
  const std::string run = RunOf(id);
  world_.Expect(204, "sender", "DELETE", "jobs/{id}", {{"id", id}});
  const json::object job = Job(id);
  EXPECT_EQ(job.at("state"), "cancelled");
  EXPECT_FALSE(job.at("ended_at").is_null());
  world_.WaitForRun(run);
  EXPECT_EQ(world_.Expect(200, "ann", "GET", "runs/{id}", {{"id", run}}).at("state"), "stopped");
  const HttpAnswer again =
      world_.Call("sender", "DELETE", "/api/v1/jobs/{id}", "/api/v1/jobs/" + id);
  EXPECT_EQ(again.status, 409);
  EXPECT_EQ(json::parse(again.body).at("reason"), "job_ended");
  EXPECT_EQ(Job(id).at("state"), "cancelled");
}

TEST_F(BenchJobs, AJobWhoseRunAPersonStoppedHasNotFailed) {
  const std::string id = IdOf(Submit("ann", R"({"runs":[{"duration_s":600}]})")[0]);
  world_.Expect(202, "ann", "POST", "runs/{id}/stop", {{"id", RunOf(id)}}, "{}");
  const json::object job = Ended(id);
  EXPECT_EQ(job.at("state"), "cancelled");
  EXPECT_EQ(job.at("error"), "its run was stopped");
}

TEST_F(BenchJobs, TenThousandRunsAreOneRequest) {
  const auto batch_of = [](int count) {
    std::string runs;
    for (int i = 0; i < count; ++i) {
      runs += std::string(i == 0 ? "" : ",") +
              R"({"duration_s":20,"faults":[{"component":"R1","value":)" + std::to_string(10 + i) +
              R"(,"at_s":10}]})";
    }
    return R"({"runs":[)" + runs + "]}";
  };
  const HttpAnswer refused =
      world_.Call("ann", "POST", "/api/v1/jobs", "/api/v1/jobs", batch_of(10'001));
  EXPECT_EQ(refused.status, 400);
  const json::object batch = world_.Expect(202, "ann", "POST", "jobs", {}, batch_of(10'000));
  EXPECT_EQ(batch.at("count"), 10'000);
  const json::array& items = batch.at("items").as_array();
  EXPECT_EQ(items.size(), 500u);
  EXPECT_EQ(Ended(IdOf(items[0])).at("state"), "finished");
  const json::object newest = world_.Expect(200, "ann", "GET", "jobs");
  EXPECT_EQ(newest.at("items").at(0).at("state"), "waiting");
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
