#include "server/upkeep/asked_checks.h"

#include <string>
#include <string_view>

#include "tests/server/upkeep/upkeep_fixture.h"

namespace faultlab::server {
namespace {

TEST(AskedChecks, AreDoneInTheirOrderEachOnceUntilItsVerdictIsTold) {
  AskedChecks checks;
  const lab::Lease first{.rig = "b", .epoch = 3};
  const lab::Lease newer{.rig = "b", .epoch = 4};
  EXPECT_TRUE(checks.Add(first));
  EXPECT_TRUE(checks.Add(newer));
  EXPECT_FALSE(checks.Add(first)) << "it waits";
  EXPECT_EQ(checks.Begin().epoch, 3u);
  EXPECT_FALSE(checks.Add(first)) << "it goes on";
  checks.End(first);
  EXPECT_TRUE(checks.Add(first));
  EXPECT_EQ(checks.Begin().epoch, 4u);
  EXPECT_EQ(checks.Begin().epoch, 3u);
  EXPECT_TRUE(checks.empty());
}

TEST(NotBegun, PutsOffWhatTellsNothingOfTheRig) {
  using core::ErrorCode;
  EXPECT_TRUE(NotBegun({ErrorCode::kUnavailable, "the rig does not answer", "/rig"}).put_off);
  EXPECT_TRUE(NotBegun({ErrorCode::kNotFound, "no rig", "/rig"}).put_off);
  const lab::RigVerdict stuck = NotBegun({ErrorCode::kBusy, "in use", "/rig"});
  EXPECT_FALSE(stuck.put_off) << "its last run does not let go";
  EXPECT_FALSE(stuck.passed);
}

class TellVerdictTest : public UpkeepFixture {
 protected:
  bool Tell(const lab::RigVerdict& verdict) {
    return TellVerdict(*lab_, asked_, verdict, [this](std::string_view line) { log_ += line; });
  }
  void Claim() {
    const core::Status claimed =
        lab_->Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
          TRY_DONE(scheduler.AddRig("b", "desks", false));
          return scheduler.Claim("b", lab_->member(), now);
        });
    ASSERT_TRUE(claimed.ok()) << claimed.error().message;
  }
  std::string log_;
};

TEST_F(TellVerdictTest, MakesTheRigReadyOrTakesItOut) {
  Claim();
  EXPECT_FALSE(Tell({.passed = true}));
  EXPECT_EQ(RigNow("b").status, lab::RigStatus::kReady);
  (void)lab_->Do(
      [](lab::Scheduler& scheduler, WallTime now) { return scheduler.Recheck("b", now); });
  EXPECT_FALSE(Tell({.text = "a relay sticks"}));
  EXPECT_EQ(RigNow("b").status, lab::RigStatus::kQuarantined);
  EXPECT_EQ(RigNow("b").reason, "the check between users failed: a relay sticks");
}

TEST_F(TellVerdictTest, OfAnOlderCheckIsGivenUpAndThatOfNoRigTooButIsLogged) {
  Claim();
  --asked_.epoch;
  EXPECT_FALSE(Tell({.passed = true}));
  EXPECT_EQ(RigNow("b").status, lab::RigStatus::kCleaning);
  EXPECT_EQ(log_, "");
  asked_.rig = "c";
  EXPECT_FALSE(Tell({.passed = true})) << "another try would be the same";
  EXPECT_NE(log_, "");
}

TEST_F(TellVerdictTest, IsToldAgainWhileTheDatabaseIsAway) {
  using lab::rehearsal::NextWrite;
  Claim();
  faults_.next = NextWrite::kRefused;
  EXPECT_TRUE(Tell({.passed = true}));
  EXPECT_NE(log_, "");
  EXPECT_EQ(RigNow("b").status, lab::RigStatus::kCleaning);
  faults_.next = NextWrite::kAnswerLost;  // stored, but nobody knows
  EXPECT_TRUE(Tell({.passed = true}));
  EXPECT_FALSE(Tell({.passed = true}));
  EXPECT_EQ(RigNow("b").status, lab::RigStatus::kReady);
}

}  // namespace
}  // namespace faultlab::server
