// A claim of a job is a lease: a server that has lost it cannot change the job.
#include "server/jobs/job_store.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include "server/lab/members.h"
#include "server/storage/recording_store.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
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
    for (const Claimant& each : {kA, kB}) Join(each);
  }
  /// From now on this is the process of the member.
  void Join(const Claimant& who) {
    EXPECT_TRUE(database_
                    ->Write(Durability::kPromise,
                            [&](Transaction& tx) -> core::Status {
                              lab::members::Put(tx, {who.server_id, who.boot, "", kStart});
                              return core::Done{};
                            })
                    .ok());
  }
  void Leave(const Claimant& who) {
    EXPECT_TRUE(database_
                    ->Write(Durability::kPromise,
                            [&](Transaction& tx) -> core::Status {
                              lab::members::Remove(tx, who.server_id, kStart);
                              return core::Done{};
                            })
                    .ok());
  }
  Job Claimed(const Claimant& who, const JobsLeftOut& left_out = {}) {
    const auto job = jobs_.Claim(who, left_out, kStart);
    EXPECT_TRUE(job.ok() && job.value().has_value());
    return job.ok() ? job.value().value_or(Job{}) : Job{};
  }
  bool Claims(const Claimant& who, const JobsLeftOut& left_out = {}) {
    const auto job = jobs_.Claim(who, left_out, kStart);
    EXPECT_TRUE(job.ok());
    return job.ok() && job.value().has_value();
  }
  void AddOne(const std::string& id,
              const std::string& owner,
              const std::string& rig,
              int second,
              const std::string& recording = "") {
    Job job;
    job.id = id;
    job.owner = owner;
    job.rig = rig;
    job.recording = recording;
    job.created_at = kStart + seconds(second);
    EXPECT_TRUE(jobs_.Add({job}).ok());
  }
  /// Every write by a server whose claim is lost is refused.
  void ExpectStale(const Job& lost) {
    const Job before = jobs_.Get(lost.id).value();
    const auto stale = [](const core::Status& status) {
      return !status.ok() && status.error().code == ErrorCode::kStale;
    };
    EXPECT_TRUE(stale(jobs_.SetRun(lost, "run-of-the-zombie")));
    EXPECT_TRUE(stale(jobs_.SetResult(lost, "{}")));
    EXPECT_TRUE(stale(jobs_.GiveBack(lost)));
    EXPECT_TRUE(stale(jobs_.Finish(lost, "finished", "", kStart)));
    const Job after = jobs_.Get(lost.id).value();
    EXPECT_EQ(after.state, before.state);
    EXPECT_EQ(after.run_id, before.run_id);
    EXPECT_EQ(after.result, before.result);
    EXPECT_EQ(after.attempts, before.attempts);
  }

  const Claimant kA{"a", "boot-a"};
  const Claimant kB{"b", "boot-b"};
  tests::TestDatabase database_{GetParam()};
  JobStore jobs_{*database_};
};

TEST_P(JobStoreTest, AServerThatWasFrozenFinishesNothingOfTheNextClaim) {
  const Job frozen = Claimed(kA);
  EXPECT_EQ(jobs_.Reap(kStart).value(), 0) << "its server is a member";
  Leave(kA);
  ExpectStale(frozen);  // before anybody has noticed
  ASSERT_EQ(jobs_.Reap(kStart).value(), 1);
  ExpectStale(frozen);
  const Job next = Claimed(kB);
  EXPECT_EQ(next.attempts, 2);
  EXPECT_EQ(next.server_id, "b");
  ExpectStale(frozen);
  EXPECT_TRUE(jobs_.SetRun(next, "run-b").ok());
  EXPECT_TRUE(jobs_.Finish(next, "finished", "", kStart).ok());
  ExpectStale(next);  // the job has ended for everybody
  EXPECT_EQ(jobs_.Get("job-1").value().run_id, "run-b");
}

TEST_P(JobStoreTest, TheSameServerStartedAnewIsAnotherClaim) {
  const Job before = Claimed(kA);
  const Claimant again{"a", "boot-a-2"};
  Join(again);
  ExpectStale(before);
  EXPECT_FALSE(Claims(kA)) << "the process that was replaced";
  ASSERT_EQ(jobs_.Reap(kStart).value(), 1);
  const Job after = Claimed(again);
  ExpectStale(before);
  EXPECT_TRUE(jobs_.GiveBack(after).ok());
  ExpectStale(after);
}

TEST_P(JobStoreTest, AServerThatLostItsPlaceAndJoinsAgainHasLostItsClaims) {
  const Job before = Claimed(kA);
  Leave(kA);
  const Claimant again{"a", "boot-a-2"};
  Join(again);
  ExpectStale(before);
  EXPECT_EQ(jobs_.HeldBy(again).value().size(), 0u);
  ASSERT_EQ(jobs_.Reap(kStart).value(), 1);
  EXPECT_EQ(Claimed(again).attempts, 2);
}

TEST_P(JobStoreTest, AJobOnWhichThreeServersDiedFails) {
  for (int i = 0; i < JobStore::kAttemptsMax; ++i) {
    const Claimant who{"c", "boot-" + std::to_string(i)};
    Join(who);
    EXPECT_EQ(Claimed(who).attempts, i + 1);
    Leave(who);
    ASSERT_EQ(jobs_.Reap(kStart).value(), 1);
  }
  EXPECT_EQ(jobs_.Get("job-1").value().state, "failed");
}

TEST_P(JobStoreTest, ACancelledJobIsOverForWhoRunsIt) {
  const Job claimed = Claimed(kA);
  ASSERT_TRUE(jobs_.SetRun(claimed, "run-a").ok());
  EXPECT_THAT(jobs_.HeldBy(kA).value(), testing::ElementsAre("job-1"));
  const auto cancelled = jobs_.Cancel("job-1", kStart);
  ASSERT_TRUE(cancelled.ok());
  EXPECT_EQ(cancelled.value().run_id, "run-a");
  ExpectStale(claimed);
  EXPECT_EQ(jobs_.Get("job-1").value().state, "cancelled");
  EXPECT_TRUE(jobs_.HeldBy(kA).value().empty());
  EXPECT_EQ(jobs_.Cancel("job-1", kStart).error().reason, "job_ended");
}

TEST_P(JobStoreTest, OnlyJobsThatCanBeginAreClaimed) {
  AddOne("job-2", "user:1", "bench-1", 1);
  AddOne("job-3", "user:1", "bench-1", 2);
  AddOne("job-4", "user:2", "bench-1", 3);
  EXPECT_FALSE(Claims(kA, {{"", "bench-1"}, {}, {}}));
  const JobsLeftOut::OfOwner ann{{}, {"job-2"}};
  const JobsLeftOut::OfOwner bob{{}, {"job-4"}};
  EXPECT_EQ(Claimed(kA, {{""}, {}, {{"user:1", ann}, {"user:2", bob}}}).id, "job-3");
  EXPECT_FALSE(jobs_.ClaimThis(kB, "job-3", kStart).value()) << "it runs";
  EXPECT_EQ(jobs_.ClaimThis(kB, "job-2", kStart).value()->server_id, "b");
  std::vector<std::string> waiting;
  AddOne("job-5", "user:1", "bench-1", 4);
  AddOne("job-6", "user:1", "bench-1", 5);
  const auto on_benches = jobs_.WaitingOn({"bench-1", "bench-2"}, 1);
  for (const Job& job : on_benches.value()) waiting.push_back(job.id);
  EXPECT_THAT(waiting, testing::ElementsAre("job-5", "job-4")) << "one of each owner";
}

TEST_P(JobStoreTest, WhatRunsAndWhatComputesIsLeftOutForAllOrForOneOwner) {
  AddOne("job-2", "user:1", "", 1, "rec-1");
  AddOne("job-3", "user:2", "", 2, "rec-1");
  const auto claimed = [&](const JobsLeftOut& left_out) {
    const Job job = Claimed(kA, left_out);
    EXPECT_TRUE(jobs_.GiveBack(job).ok());
    return job.id;
  };
  constexpr JobsLeftOut::Kinds kRuns{true, false};
  constexpr JobsLeftOut::Kinds kComputing{false, true};
  EXPECT_EQ(claimed({}), "job-1");
  EXPECT_EQ(claimed({{}, kComputing, {}}), "job-1");
  EXPECT_EQ(claimed({{}, kRuns, {}}), "job-2");
  EXPECT_EQ(claimed({{}, {}, {{"user:1", {kRuns, {}}}}}), "job-2");
  EXPECT_EQ(claimed({{}, kRuns, {{"user:1", {kComputing, {}}}}}), "job-3");
  EXPECT_FALSE(Claims(kA, {{}, kComputing, {{"user:1", {kRuns, {}}}}}));
}

TEST_P(JobStoreTest, WhoHasJustBeenServedGoesAfterWhoHasWaited) {
  AddOne("job-2", "user:1", "", 0);
  AddOne("job-3", "user:2", "", 2);
  const Job first = Claimed(kA);
  EXPECT_EQ(first.id, "job-1");
  ASSERT_TRUE(jobs_.Finish(first, "finished", "", kStart + seconds(3)).ok());
  EXPECT_EQ(Claimed(kA).id, "job-3") << "though job-2 is older";
}

TEST_P(JobStoreTest, WhatAnOwnersJobsMayWorkOnIsBounded) {
  RunRecord recording;
  recording.id = "rec-1";
  ASSERT_TRUE(RecordingStore(*database_).Begin(recording).ok());
  ASSERT_TRUE(database_
                  ->Write(Durability::kPromise,
                          [&](Transaction& tx) -> core::Status {
                            const std::int64_t half = JobStore::kSamplesMax / 2;
                            tx.sql() << "UPDATE recording SET samples = :half", soci::use(half);
                            return core::Done{};
                          })
                  .ok());
  AddOne("job-2", "user:1", "", 1, "rec-1");
  Job more;
  more.id = "job-3";
  more.owner = "user:1";
  more.recording = "rec-1";
  Job yet_more = more;
  yet_more.id = "job-4";
  EXPECT_EQ(jobs_.Add({more, yet_more}).error().reason, "jobs_work_full");
  ASSERT_TRUE(jobs_.Add({more}).ok());
  EXPECT_EQ(jobs_.Add({yet_more}).error().reason, "jobs_work_full");
  yet_more.owner = "user:2";
  EXPECT_TRUE(jobs_.Add({yet_more}).ok()) << "another's are not counted";
  ASSERT_TRUE(jobs_.Cancel("job-2", kStart).ok());
  yet_more.id = "job-5";
  yet_more.owner = "user:1";
  EXPECT_TRUE(jobs_.Add({yet_more}).ok());
}

TEST_P(JobStoreTest, OwnersTakeTurnsAndEachOnesJobsAreDoneInOrder) {
  AddOne("job-2", "user:1", "", 1);
  AddOne("job-3", "user:2", "sim-1", 2);
  AddOne("job-4", "user:3", "", 3);
  std::vector<std::string> order;
  for (int i = 0; i < 4; ++i) order.push_back(Claimed(kA).id);
  EXPECT_THAT(order, testing::ElementsAre("job-1", "job-3", "job-4", "job-2"));
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
  const Job claimed = Claimed(kA);
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
}  // namespace faultlab::server
