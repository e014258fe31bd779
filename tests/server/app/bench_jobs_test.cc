// Jobs on rigs that need a session, and jobs that only diagnose, in a whole server over HTTP.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <thread>

#include "tests/support/await.h"
#include "tests/system/contract/contract_world.h"

namespace faultlab::tests {
namespace {

namespace json = boost::json;

class BenchJobs : public ContractWorld {
 protected:
  json::object Job(const std::string& id) { return Expect(200, "ann", "GET jobs/" + id); }
  json::array Submit(const std::string& who, const std::string& body) {
    const json::object batch = Expect(202, who, "POST jobs", body);
    return batch.empty() ? json::array{} : batch.at("items").as_array();
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
    return job.at("run").is_null() ? "" : server::Text(job, "run");
  }
  static bool Over(const json::object& job) {
    return job.at("state") != "waiting" && job.at("state") != "running";
  }
  std::string Ticket(const std::string& who) {
    const json::object asked = Expect(201, who, "POST tickets", R"({"rig_class":"bench"})");
    return server::Id(asked.at("ticket"));
  }
  json::object Accepted(const std::string& who) {
    return Expect(200, who, "POST tickets/" + Ticket(who) + "/accept", "{}");
  }
};

TEST_F(BenchJobs, RunInGapsInASessionOfTheirOwnAndGiveTheRigBackToItsCheck) {
  WaitForBenches(2);
  const json::array jobs = Submit(
      "ann",
      R"({"name":"b","runs":[{"rig":"bench-1","duration_s":3,"name":"R1 10"},{"rig":"bench-2","duration_s":3}]})");
  ASSERT_EQ(jobs.size(), 2u);
  for (const json::value& asked : jobs) {
    const json::object job = Ended(server::Id(asked));
    EXPECT_EQ(job.at("state"), "finished") << json::serialize(job);
    const json::object run = Expect(200, "ann", "GET runs/" + server::Text(job, "run"));
    EXPECT_TRUE(run.at("rig").as_string().starts_with("bench-"));
    EXPECT_EQ(run.at("samples").as_int64(), 300);
  }
  EXPECT_EQ(Job(server::Id(jobs[0])).at("run_name"), "R1 10");
  WaitForBenches(2);
  EXPECT_TRUE(Expect(200, "ann", "GET sessions").at("items").as_array().empty());
}

TEST_F(BenchJobs, WaitBehindPeopleAndAreNoWayToTheRigForTheirOwner) {
  WaitForBenches(2);
  const json::object ann = Accepted("ann");
  const json::object bob = Accepted("bob");
  const std::string id =
      server::Id(Submit("ann", R"({"runs":[{"rig":"bench-1","duration_s":3}]})")[0]);
  // The job gets its ticket before the person asks; nevertheless the person is next.
  json::array tickets;
  EXPECT_TRUE(tests::Await([&] {
    tickets = Expect(200, "ann", "GET tickets").at("items").as_array();
    return !tickets.empty();
  }));
  ASSERT_EQ(tickets.size(), 1u);
  (void)Ticket("teacher");
  const json::object place = Expect(200, "teacher", "GET tickets");
  EXPECT_EQ(place.at("items").at(0).at("place"), 1);
  EXPECT_EQ(Job(id).at("state"), "waiting");
  const auto end = [&](const std::string& who, const json::object& session) {
    Expect(204, who, "POST sessions/" + server::Id(session) + "/end", "{}");
  };
  end("bob", bob);
  end("ann", ann);
  EXPECT_EQ(Ended(id).at("state"), "finished");
}

TEST_F(BenchJobs, ACancelledOneLeavesTheQueue) {
  WaitForBenches(2);
  (void)Accepted("ann");
  (void)Accepted("bob");
  const auto tickets = [&] {
    return Expect(200, "ann", "GET tickets").at("items").as_array().size();
  };
  const std::string id =
      server::Id(Submit("ann", R"({"runs":[{"rig":"bench-1","duration_s":3}]})")[0]);
  ASSERT_TRUE(tests::Await([&] { return tickets() == 1; }));
  Expect(204, "ann", "DELETE jobs/" + id);
  EXPECT_EQ(Job(id).at("state"), "cancelled");
  EXPECT_EQ(tickets(), 0U);
  // The next is cancelled at once, perhaps while it is given its place: only the last one waits.
  const std::string next =
      server::Id(Submit("ann", R"({"runs":[{"rig":"bench-1","duration_s":3}]})")[0]);
  Expect(204, "ann", "DELETE jobs/" + next);
  (void)Submit("ann", R"({"runs":[{"rig":"bench-1","duration_s":3}]})");
  EXPECT_TRUE(tests::Await([&] { return tickets() == 1; }));
}

TEST_F(BenchJobs, LeaveThePlacesToOthersWhileTheyWait) {
  WaitForBenches(2);
  (void)Accepted("ann");
  (void)Accepted("bob");
  std::string runs;
  for (int i = 0; i < 8; ++i) runs += R"({"rig":"bench-1","duration_s":3},)";
  (void)Submit("ann", R"({"runs":[)" + runs + R"({"rig":"bench-2","duration_s":3}]})");
  const std::string id = server::Id(Submit("ann", R"({"runs":[{"duration_s":3}]})")[0]);
  EXPECT_EQ(Ended(id).at("state"), "finished");
  const json::array all = Expect(200, "ann", "GET jobs").at("items").as_array();
  for (const json::value& job : all) {
    EXPECT_EQ(job.at("state"), server::Id(job) == id ? "finished" : "waiting");
  }
}

TEST_F(BenchJobs, ARunningOneIsCancelledWithTheScopeOfJobsAlone) {
  const json::object batch = Expect(202, "sender", "POST jobs", R"({"runs":[{"duration_s":600}]})");
  const std::string id = server::Id(batch.at("items").at(0));
  const std::string run = RunOf(id);
  Expect(204, "sender", "DELETE jobs/" + id);
  const json::object job = Job(id);
  EXPECT_EQ(job.at("state"), "cancelled");
  EXPECT_FALSE(job.at("ended_at").is_null());
  WaitForRun(run);
  EXPECT_EQ(Expect(200, "ann", "GET runs/" + run).at("state"), "stopped");
  const HttpAnswer again = Call("sender", "DELETE jobs/" + id);
  EXPECT_EQ(again.status, 409);
  EXPECT_EQ(server::ReasonOf(again), "job_ended");
  EXPECT_EQ(Job(id).at("state"), "cancelled");
}

TEST_F(BenchJobs, AJobWhoseRunAPersonStoppedHasNotFailed) {
  const std::string id = server::Id(Submit("ann", R"({"runs":[{"duration_s":600}]})")[0]);
  Expect(202, "ann", "POST runs/" + RunOf(id) + "/stop", "{}");
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
  const HttpAnswer refused = Call("ann", "POST jobs", batch_of(10'001));
  EXPECT_EQ(refused.status, 400);
  const json::object batch = Expect(202, "ann", "POST jobs", batch_of(10'000));
  EXPECT_EQ(batch.at("count"), 10'000);
  const json::array& items = batch.at("items").as_array();
  EXPECT_EQ(items.size(), 500u);
  EXPECT_EQ(Ended(server::Id(items[0])).at("state"), "finished");
  const json::object newest = Expect(200, "ann", "GET jobs");
  EXPECT_EQ(newest.at("items").at(0).at("state"), "waiting");
}

TEST_F(BenchJobs, ADiagnosisOfAnUploadIsAJobWithItsSettings) {
  std::string csv = "t_s,uc_v,um_v\n";
  for (int i = 0; i < 1200; ++i) {
    const double uc_v = (i * 7919 / 13) % 2 == 0 ? 2.0 : 3.0;
    csv += std::to_string(i * 0.01) + "," + std::to_string(uc_v) + "," +
           std::to_string(2.4 * uc_v) + "\n";
  }
  const json::object uploaded = Expect(201, "ann", "POST recordings", csv, server::kCsv);
  const std::string recording = server::Id(uploaded);
  const auto body = [&](const std::string& settings) {
    return R"({"runs":[{"diagnose":{"recording":")" + recording + "\"" + settings + "}}]}";
  };
  const json::object job =
      Ended(server::Id(Submit("ann", body(R"(,"channels":"um","values":"table2")"))[0]));
  EXPECT_EQ(job.at("state"), "finished") << json::serialize(job);
  EXPECT_EQ(job.at("recording"), json::string(recording));
  EXPECT_EQ(job.at("diagnosis").at("samples"), 1200);
  EXPECT_TRUE(job.at("diagnosis").as_object().contains("verdict"));
  EXPECT_TRUE(job.at("run").is_null());
  const HttpAnswer foreign = Call("bob", "POST jobs", body(""));
  EXPECT_EQ(foreign.status, 404) << foreign.body;
  const HttpAnswer refused = Call("ann", "POST jobs", body(R"(,"healthy_from_s":9)"));
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(json::parse(refused.body).at("field"), "/runs/0/diagnose/healthy_to_s");
}

}  // namespace
}  // namespace faultlab::tests
