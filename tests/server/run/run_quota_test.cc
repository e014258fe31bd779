#include "server/run/run_quota.h"

#include <gtest/gtest.h>

#include <vector>

namespace faultlab::server {
namespace {

using enum RunKind;

std::string ReasonOf(const core::Result<std::shared_ptr<void>>& place) {
  return place.ok() ? "" : place.error().reason;
}

class RunQuotaTest : public ::testing::Test {
 protected:
  std::string Take(const std::string& caller, RunKind kind, std::int64_t samples = 0) {
    auto place = places_.Take(caller, kind, samples, {});
    if (place.ok()) held_.push_back(place.value());
    return ReasonOf(place);
  }

  RunQuota places_{{.runs_max = 6,
                    .runs_per_caller_max = 3,
                    .simulators_per_caller = 2,
                    .simulators_of_guests = 3,
                    .replayed_samples_max = 1000}};
  std::vector<std::shared_ptr<void>> held_;
};

TEST_F(RunQuotaTest, OneCallerCannotTakeThemAll) {
  EXPECT_EQ(Take("user:1", kSimulator), "");
  EXPECT_EQ(Take("user:1", kSimulator), "");
  EXPECT_EQ(Take("user:1", kSimulator), "your_simulators_full");
  EXPECT_EQ(Take("user:1", kReplay), "");
  EXPECT_EQ(Take("user:1", kReplay), "your_runs_full");
  EXPECT_EQ(Take("user:2", kSimulator), "");
  held_.erase(held_.begin());
  EXPECT_EQ(Take("user:1", kSimulator), "");
}

TEST_F(RunQuotaTest, GuestsTogetherLeaveSomeToAccounts) {
  for (const char* guest : {"guest 1", "guest 2", "guest 3"}) {
    EXPECT_EQ(Take(guest, kSimulator), "");
  }
  EXPECT_EQ(Take("guest 4", kSimulator), "runs_of_guests_full");
  EXPECT_EQ(Take("guest 4", kReplay), "runs_of_guests_full") << "half of all runs";
  EXPECT_EQ(Take("user:1", kSimulator), "");
  held_.erase(held_.begin());
  EXPECT_EQ(Take("guest 4", kSimulator), "");
}

TEST_F(RunQuotaTest, WhoeverHasASessionFindsRoomOnAFullServer) {
  for (int i = 0; i < 6; ++i) EXPECT_EQ(Take("user:" + std::to_string(i), kReplay), "");
  EXPECT_EQ(Take("user:7", kSimulator), "runs_full");
  EXPECT_EQ(Take("user:7", kLeased), "");
  EXPECT_EQ(Take("user:1", kLeased), "");
}

TEST_F(RunQuotaTest, ReplaysShareTheMemory) {
  EXPECT_EQ(Take("user:1", kReplay, 700), "");
  EXPECT_EQ(Take("user:2", kReplay, 400), "runs_full");
  EXPECT_EQ(Take("user:2", kReplay, 300), "");
  held_.clear();
  EXPECT_EQ(Take("user:2", kReplay, 1000), "");
}

TEST_F(RunQuotaTest, JobsAreNobodysRuns) {
  for (int i = 0; i < 6; ++i) EXPECT_EQ(Take("", kSimulator), "");
  EXPECT_EQ(Take("", kSimulator), "runs_full");
}

}  // namespace
}  // namespace faultlab::server
