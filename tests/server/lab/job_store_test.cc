// A claim of a job is a lease: a server that has lost it cannot change the job.
#include "server/lab/job_store.h"

#include <gtest/gtest.h>
#include <soci/soci.h>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

using core::ErrorCode;
using std::chrono::seconds;

constexpr WallTime kStart{std::chrono::milliseconds{1'770'033'600'000}};

class JobStoreTest : public testing::TestWithParam<Engine> {
 protected:
  JobStoreTest() {
    Job job;
    job.id = "job-1";
    job.owner = "user:1";
    job.body = "{}";
    job.created_at = kStart;
    EXPECT_TRUE(jobs_.Add({job}).ok());
  }
  Job Claimed(const std::string& server, WallTime now) {
    const auto job = jobs_.Claim(server, now, now + seconds(60));
    EXPECT_TRUE(job.ok() && job.value().has_value());
    return job.ok() ? job.value().value_or(Job{}) : Job{};
  }
  bool Claims(const std::string& server, WallTime now) {
    const auto job = jobs_.Claim(server, now, now + seconds(60));
    EXPECT_TRUE(job.ok());
    return job.ok() && job.value().has_value();
  }
  /// Every write by a server whose claim is lost is refused.
  void ExpectStale(const Job& lost, WallTime now) {
    const Job before = jobs_.Get(lost.id).value();
    const auto stale = [](const core::Status& status) {
      return !status.ok() && status.error().code == ErrorCode::kStale;
    };
    EXPECT_TRUE(stale(jobs_.Renew(lost, now + seconds(60))));
    EXPECT_TRUE(stale(jobs_.SetRun(lost, "run-of-the-zombie")));
    EXPECT_TRUE(stale(jobs_.SetResult(lost, "{}")));
    EXPECT_TRUE(stale(jobs_.GiveBack(lost, now)));
    EXPECT_TRUE(stale(jobs_.HandTo(lost, "c", now)));
    EXPECT_TRUE(stale(jobs_.Finish(lost, "finished", "", now)));
    const Job after = jobs_.Get(lost.id).value();
    EXPECT_EQ(after.state, before.state);
    EXPECT_EQ(after.run_id, before.run_id);
    EXPECT_EQ(after.result, before.result);
    EXPECT_EQ(after.attempts, before.attempts);
  }

  tests::TestDatabase database_{GetParam()};
  JobStore jobs_{*database_};
};

TEST_P(JobStoreTest, AServerThatWasFrozenFinishesNothingOfTheNextClaim) {
  const Job frozen = Claimed("a", kStart);
  const WallTime later = kStart + seconds(65);
  ASSERT_EQ(jobs_.Reap(later, "").value(), 1);
  ExpectStale(frozen, later);
  const Job next = Claimed("b", later);
  EXPECT_EQ(next.attempts, 2);
  EXPECT_EQ(next.server_id, "b");
  ExpectStale(frozen, later);
  EXPECT_TRUE(jobs_.SetRun(next, "run-b").ok());
  EXPECT_TRUE(jobs_.Renew(next, later + seconds(60)).ok());
  EXPECT_TRUE(jobs_.Finish(next, "finished", "", later).ok());
  ExpectStale(next, later);  // the job has ended for everybody
  EXPECT_EQ(jobs_.Get("job-1").value().run_id, "run-b");
}

TEST_P(JobStoreTest, TheSameServerStartedAnewIsAnotherClaim) {
  const Job before = Claimed("a", kStart);
  ASSERT_EQ(jobs_.Reap(kStart + seconds(1), "a").value(), 1);
  const Job after = Claimed("a", kStart + seconds(1));
  ExpectStale(before, kStart + seconds(2));
  EXPECT_TRUE(jobs_.GiveBack(after, kStart + seconds(2)).ok());
  ExpectStale(after, kStart + seconds(2));
}

TEST_P(JobStoreTest, AJobForAnothersRigIsItsAtOnceAndEverybodysLater) {
  const Job first = Claimed("a", kStart);
  ASSERT_TRUE(jobs_.HandTo(first, "b", kStart + seconds(10)).ok());
  EXPECT_FALSE(Claims("a", kStart + seconds(9)));
  const Job second = Claimed("b", kStart + seconds(9));
  ASSERT_TRUE(jobs_.HandTo(second, "b", kStart + seconds(20)).ok());
  ExpectStale(second, kStart + seconds(11));
  EXPECT_TRUE(Claims("a", kStart + seconds(20))) << "b is gone";
  EXPECT_EQ(jobs_.Get("job-1").value().attempts, 1);
}

TEST_P(JobStoreTest, AJobThatFoundNoRigIsNobodysBeforeItsNextLook) {
  const Job first = Claimed("a", kStart);
  ASSERT_TRUE(jobs_.GiveBack(first, kStart + seconds(1)).ok());
  EXPECT_FALSE(Claims("a", kStart));
  EXPECT_FALSE(Claims("b", kStart));
  EXPECT_TRUE(Claims("a", kStart + seconds(1)));
}

TEST_P(JobStoreTest, TheBodiesOfJobsThatWaitOrRunAreCountedAndGoAtTheEnd) {
  Job job;
  job.owner = "user:1";
  job.run_name = "wide";
  job.created_at = kStart;
  job.body = std::string(JobStore::kBodyBytesMax / 2 - 1, 'x');  // in addition to the "{}" of job-1
  const auto add = [&](const std::string& id) {
    job.id = id;
    return jobs_.Add({job});
  };
  ASSERT_TRUE(add("a-1").ok());
  ASSERT_TRUE(add("a-2").ok());
  const core::Status full = add("a-3");
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().reason, "jobs_full");
  EXPECT_EQ(jobs_.BodyBytesOf("user:1").value(), JobStore::kBodyBytesMax);
  EXPECT_EQ(jobs_.List("user:1", "", 0, "", 10).value().front().body, "") << "a list has no bodies";
  const Job claimed = Claimed("a", kStart);
  EXPECT_EQ(claimed.body.size(), job.body.size()) << "whoever does the job has it";
  EXPECT_EQ(jobs_.BodyBytesOf("user:1").value(), JobStore::kBodyBytesMax);
  ASSERT_TRUE(jobs_.Finish(claimed, "finished", "", kStart).ok());
  ASSERT_TRUE(jobs_.Cancel("a-2", kStart).ok());
  EXPECT_EQ(jobs_.BodyBytesOf("user:1").value(), 2);
  std::int64_t bytes = -1;
  ASSERT_TRUE(database_
                  ->Read([&](Transaction& tx) -> core::Status {
                    tx.sql() << "SELECT SUM(LENGTH(body)) FROM job", soci::into(bytes);
                    return core::Done{};
                  })
                  .ok());
  EXPECT_EQ(bytes, 2) << "nothing is left of them";
  EXPECT_EQ(jobs_.Get("a-1").value().run_name, "wide");
}

TEST_P(JobStoreTest, OfJobsThatEndedWithoutARunTheNewestAreKept) {
  for (int batch = 0; batch < 4; ++batch) {
    std::vector<Job> jobs(400);
    for (std::size_t i = 0; i < jobs.size(); ++i) {
      jobs[i].id = "job-" + std::to_string(1000 + batch * 400 + static_cast<int>(i));
      jobs[i].owner = "user:1";
      jobs[i].created_at = kStart;
    }
    ASSERT_TRUE(jobs_.Add(jobs).ok());
    for (const Job& job : jobs) {
      ASSERT_TRUE(jobs_.Cancel(job.id, kStart + seconds(batch)).ok());
    }
  }
  Job last;
  last.id = "last";
  last.owner = "user:1";
  ASSERT_TRUE(jobs_.Add({last}).ok());
  EXPECT_EQ(jobs_.List("user:1", "", 0, "", 5000).value().size(),
            static_cast<std::size_t>(JobStore::kIdleKept + 2));
  EXPECT_FALSE(jobs_.Get("job-1000").ok()) << "the oldest has gone";
  EXPECT_TRUE(jobs_.Get("job-2599").ok());
}

INSTANTIATE_TEST_SUITE_P(Engines, JobStoreTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::lab
