// A claim of a job is a lease: who has lost it changes nothing of it any more.
#include "server/lab/job_store.h"

#include <gtest/gtest.h>

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
  /// Every write of a claim, refused as that of a stranger.
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
  ExpectStale(next, later);  // it is over for everybody
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

INSTANTIATE_TEST_SUITE_P(Engines, JobStoreTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::lab
