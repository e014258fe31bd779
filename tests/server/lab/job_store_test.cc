#include "server/lab/job_store.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

using std::chrono::seconds;

constexpr WallTime kStart{std::chrono::milliseconds{1'800'000'000'000}};

class JobStoreTest : public testing::TestWithParam<Engine> {
 protected:
  JobStoreTest() {
    Job job;
    job.id = "j";
    job.owner = "user:1";
    job.body = "{}";
    job.created_at = kStart;
    EXPECT_TRUE(jobs_.Add({job}).ok());
  }
  bool Claims(const std::string& server, WallTime now) {
    const auto job = jobs_.Claim(server, now, now + seconds(60));
    EXPECT_TRUE(job.ok());
    return job.ok() && job.value().has_value();
  }

  tests::TestDatabase database_{GetParam()};
  JobStore jobs_{*database_};
};

TEST_P(JobStoreTest, AJobForAnothersRigIsItsAtOnceAndEverybodysLater) {
  ASSERT_TRUE(Claims("a", kStart));
  ASSERT_TRUE(jobs_.HandTo("j", "b", kStart + seconds(10)).ok());
  EXPECT_FALSE(Claims("a", kStart + seconds(9)));
  EXPECT_TRUE(Claims("b", kStart + seconds(9)));
  ASSERT_TRUE(jobs_.HandTo("j", "b", kStart + seconds(20)).ok());
  EXPECT_TRUE(Claims("a", kStart + seconds(20))) << "b is gone";
  EXPECT_EQ(jobs_.Get("j").value().attempts, 1);
}

TEST_P(JobStoreTest, AJobThatFoundNoRigIsNobodysBeforeItsNextLook) {
  ASSERT_TRUE(Claims("a", kStart));
  ASSERT_TRUE(jobs_.GiveBack("j", kStart + seconds(1)).ok());
  EXPECT_FALSE(Claims("a", kStart));
  EXPECT_FALSE(Claims("b", kStart));
  EXPECT_TRUE(Claims("a", kStart + seconds(1)));
}

INSTANTIATE_TEST_SUITE_P(Engines, JobStoreTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::lab
