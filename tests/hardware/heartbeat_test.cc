// While the motor is driven, heartbeats are sent, and only while both threads live.
#include "hardware/heartbeat.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/hardware/rig_runs.h"
#include "tests/hardware/test_bench.h"

namespace faultlab::hardware {
namespace {

using std::chrono::milliseconds;
constexpr Word kTick = 1;  ///< NextTickIn of less than 10 ms

class HeartbeatAlone : public testing::Test {
 protected:
  /// Ticks of 10 ms.
  void Tick(int ticks, bool main_loop_turns) {
    for (int i = 0; i < ticks; ++i) {
      clock_->Advance(milliseconds(10));
      if (main_loop_turns) heartbeat_.MainLoopTurn();
      heartbeat_.Beat(milliseconds(9));
    }
  }

  std::vector<Word> said_;
  std::shared_ptr<ManualClock> clock_ = std::make_shared<ManualClock>();
  Heartbeat heartbeat_{[this](Word word) { said_.push_back(word); }, clock_};
};

TEST(Words, PromiseTheNextTickAndAllowSilenceFromThen) {
  EXPECT_EQ(NextTickIn(milliseconds(-5)), kTick);
  EXPECT_EQ(SilenceAllowed(NextTickIn(milliseconds(9))), milliseconds(300));
  EXPECT_EQ(SilenceAllowed(NextTickIn(milliseconds(1000))), milliseconds(1300));
  for (const auto time : {milliseconds(0), milliseconds(2530), milliseconds(100'000)}) {
    EXPECT_NE(NextTickIn(time), kMotorOff);
    EXPECT_NE(NextTickIn(time), kCallForHelp);
  }
}

TEST_F(HeartbeatAlone, SpeaksAtOnceAndThenEveryFiftyMilliseconds) {
  heartbeat_.Begin();
  EXPECT_EQ(said_, std::vector<Word>{kTick});
  Tick(100, true);
  EXPECT_EQ(said_, std::vector<Word>(21, kTick));
  heartbeat_.End();
  EXPECT_EQ(said_.back(), kMotorOff);
}

TEST_F(HeartbeatAlone, SaysAtOnceThatTheNextTickIsFar) {
  heartbeat_.Begin();
  clock_->Advance(milliseconds(10));
  heartbeat_.Beat(milliseconds(990));
  ASSERT_EQ(said_.size(), 2u);
  EXPECT_EQ(SilenceAllowed(said_.back()), milliseconds(1290));
}

TEST_F(HeartbeatAlone, AllowsForADriverThatMayTakeLonger) {
  Heartbeat patient([this](Word word) { said_.push_back(word); },
                    clock_,
                    Heartbeat::Options{.driver_slack = milliseconds(750)});
  patient.Begin();
  EXPECT_EQ(SilenceAllowed(said_.back()), milliseconds(1050));
  clock_->Advance(milliseconds(50));
  patient.Beat(milliseconds(100));
  EXPECT_EQ(SilenceAllowed(said_.back()), milliseconds(1150));
}

TEST_F(HeartbeatAlone, IsSilentWhileTheMainLoopStandsStill) {
  heartbeat_.Begin();
  Tick(100, false);
  const std::size_t heard = said_.size();
  EXPECT_EQ(heard, 21u);
  Tick(100, false);
  EXPECT_EQ(said_.size(), heard) << "the loop ticks, but nobody hears a stop command";
  Tick(10, true);
  EXPECT_GT(said_.size(), heard);
}

/// A bench whose heartbeats and calls are recorded in their order.
struct WatchedBench {
  std::vector<std::pair<Word, double>> said;  ///< with the drive at that moment
  TestBench bench;

  WatchedBench() : bench(Options(*this)) {}
  static TestBenchOptions Options(WatchedBench& self) {
    TestBenchOptions options;
    options.heartbeat = std::make_shared<Heartbeat>(
        [&self](Word word) { self.said.emplace_back(word, self.bench.journal.drive_v); },
        std::make_shared<ManualClock>(),
        Heartbeat::Options{.word_every = Nanoseconds(0)});
    return options;
  }
};

TEST(PacedRigHeartbeat, BeginsBeforeTheFirstDriveAndEndsAfterDriveZero) {
  WatchedBench watched;
  Rig& rig = *watched.bench.rig;
  ASSERT_TRUE(rig.Arm(SquarePlan(20), kEpoch).ok());
  EXPECT_TRUE(watched.said.empty()) << "nothing is driven yet";
  ASSERT_TRUE(rig.Start(kEpoch).ok());
  (void)Drain(rig);
  ASSERT_GT(watched.said.size(), 20u);
  EXPECT_EQ(watched.said.front(), std::make_pair(kTick, 0.0));
  for (std::size_t i = 1; i + 1 < watched.said.size(); ++i) EXPECT_NE(watched.said[i].first, 0);
  EXPECT_EQ(watched.said.back(), std::make_pair(kMotorOff, 0.0));
}

TEST(PacedRigHeartbeat, DoesNotSayThatTheMotorIsOffWhenDriveZeroWasNotReached) {
  WatchedBench watched;
  Rig& rig = *watched.bench.rig;
  ASSERT_TRUE(rig.Arm(SquarePlan(50), kEpoch).ok());
  watched.bench.journal.fail_at = watched.bench.journal.calls + 20;
  watched.bench.journal.failures = 1'000'000;
  ASSERT_TRUE(rig.Start(kEpoch).ok());
  (void)Drain(rig);
  EXPECT_EQ(rig.state(), RigState::kTripped);
  ASSERT_FALSE(watched.said.empty());
  for (const auto& [word, drive_v] : watched.said) EXPECT_NE(word, kMotorOff);
}

}  // namespace
}  // namespace faultlab::hardware
