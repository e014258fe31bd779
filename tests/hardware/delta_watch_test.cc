// Time is what it says: each sample of a board carries its measured delta, and a run whose delta
// strays says so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "hardware/delta_watch.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/test_bench.h"

namespace faultlab::hardware {
namespace {

using std::chrono::milliseconds;

RunLog RunOf(TestBench& bench, int samples) {
  EXPECT_TRUE(bench.rig->Arm(SquarePlan(samples), Epoch{1}).ok());
  EXPECT_TRUE(bench.rig->Start(Epoch{1}).ok());
  return Drain(*bench.rig);
}

TEST(Delta, IsMeasuredFromTheMiddleOfTheWriteToTheMiddleOfTheRead) {
  auto clock = std::make_shared<ManualClock>();
  TestBench bench({.clock = clock});
  const double delta_s = bench.rig->description().delta_s;
  bench.journal.during = [&](std::string_view call) {
    if (call == "WriteDrive") clock->Advance(milliseconds(2));
    if (call == "ReadAnalog") clock->Advance(milliseconds(0));
  };
  const RunLog fast = RunOf(bench, 20);
  ASSERT_EQ(fast.samples.size(), 20u);
  for (const core::Sample& sample : fast.samples) {
    EXPECT_NEAR(sample.delta_s, delta_s - 1e-3, 1e-9);
  }
}

TEST(Delta, ThatStraysIsSaidOnceWithItsMean) {
  auto clock = std::make_shared<ManualClock>();
  TestBench bench({.clock = clock});
  const double delta_s = bench.rig->description().delta_s;
  bench.journal.during = [&](std::string_view call) {
    if (call == "WriteDrive") clock->Advance(milliseconds(6));
  };
  const RunLog log = RunOf(bench, 350);
  const auto said = log.Of(RigEventKind::kDeltaStrays);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].index, 99);
  EXPECT_NEAR(said[0].value, delta_s - 3e-3, 1e-9);
  EXPECT_THAT(said[0].text, testing::HasSubstr("6.50 ms after the drive, not 9.50 ms"));
}

TEST(Delta, WithinAFifthOfAMillisecondIsNotWorthAWord) {
  auto clock = std::make_shared<ManualClock>();
  TestBench bench({.clock = clock});
  bench.journal.during = [&](std::string_view call) {
    if (call == "WriteDrive") clock->Advance(std::chrono::microseconds(380));
  };
  EXPECT_TRUE(RunOf(bench, 350).Of(RigEventKind::kDeltaStrays).empty());
}

TEST(Delta, OfASimulatorIsNotMeasured) {
  SimulatedRigOptions options;
  options.speed = 0.0;
  auto rig = MakeSimulatedRig(options);
  ASSERT_TRUE(rig->Arm(SquarePlan(20), Epoch{1}).ok());
  ASSERT_TRUE(rig->Start(Epoch{1}).ok());
  for (const core::Sample& sample : Drain(*rig).samples) EXPECT_TRUE(std::isnan(sample.delta_s));
}

TEST(DeltaWatch, LooksAtTheMeanOfASecond) {
  DeltaWatch watch(5e-3, 0.01);
  const auto push = [&](double delta_s) { return watch.Push(core::Sample{.delta_s = delta_s}); };
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(push(i % 2 == 0 ? 4e-3 : 6e-3)) << i;  // jitter alone
  }
  for (int i = 0; i < 99; ++i) EXPECT_FALSE(push(5.21e-3));
  EXPECT_TRUE(push(5.21e-3));
}

}  // namespace
}  // namespace faultlab::hardware
