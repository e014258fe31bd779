#include "hardware/loop_quality.h"

#include <gtest/gtest.h>

#include "tests/hardware/rig_runs.h"
#include "tests/hardware/test_bench.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

TEST(TimeHistogram, HoldsEachTimeInTheBucketWhoseBoundItDoesNotPass) {
  TimeHistogram histogram;
  EXPECT_EQ(histogram.QuantileBound(0.99), 0.0);
  histogram.Count(20e-6);
  histogram.Count(20.5e-6);
  histogram.Count(0.0105);
  histogram.Count(3.0);
  EXPECT_EQ(histogram.counts[0], 1u);
  EXPECT_EQ(histogram.counts[1], 1u);
  EXPECT_EQ(histogram.counts[9], 1u) << "a tick plus 1 ms";
  EXPECT_EQ(histogram.counts[13], 1u);
  EXPECT_EQ(histogram.count(), 4u);
  EXPECT_DOUBLE_EQ(histogram.QuantileBound(0.5), 50e-6);
  EXPECT_DOUBLE_EQ(histogram.QuantileBound(1.0), 3.0);
}

TEST(TimeHistogram, OfOneRunIsTheDifferenceOfTwo) {
  TimeHistogram before;
  before.Count(0.004);
  TimeHistogram after = before;
  after.Count(0.0001);
  after.Count(0.0003);
  const TimeHistogram run = after.Since(before);
  EXPECT_EQ(run.count(), 2u);
  EXPECT_NEAR(run.sum_s, 0.0004, 1e-12);
  EXPECT_DOUBLE_EQ(run.worst_s, 0.0005) << "the bound of its bucket: the worst of all is older";
  after.Count(0.009);
  EXPECT_DOUBLE_EQ(after.Since(before).worst_s, 0.009);
  EXPECT_EQ(before.Since(before).worst_s, 0.0);
}

TEST(LoopQuality, StampsACommandFromItsAcceptanceToItsRelays) {
  TestBench* asked = nullptr;
  // The command comes while the loop sleeps; 7 ms of wall time pass until it wakes.
  const auto clock = std::make_shared<StumblingClock>([&asked](int sleep) {
    if (sleep == 21) {
      EXPECT_TRUE(
          asked->rig
              ->Command(
                  kEpoch,
                  {.kind = RigCommand::Kind::kSetComponent, .component = paper::kR1, .value = 10.0})
              .ok());
      asked->wall->Advance(std::chrono::milliseconds(7));
    }
    return Nanoseconds(0);
  });
  TestBench bench(
      TestBenchOptions{.clock = clock, .watchdog = {}, .limits = paper::Bench().limits});
  asked = &bench;
  RunPlan plan = SquarePlan(60);
  plan.faults = {{.component = paper::kR9, .value = 33e3, .at_s = 0.3}};
  ASSERT_TRUE(bench.rig->Arm(plan, kEpoch).ok());
  ASSERT_TRUE(bench.rig->Start(kEpoch).ok());
  EXPECT_EQ(Drain(*bench.rig).Of(RigEventKind::kRelayConfirmed).size(), 2u);
  const TimeHistogram actuation = bench.rig->loop_quality().actuation;
  EXPECT_EQ(actuation.count(), 1u) << "the plan's own fault is no command";
  EXPECT_DOUBLE_EQ(actuation.worst_s, 0.007);
}

}  // namespace
}  // namespace faultlab::hardware
