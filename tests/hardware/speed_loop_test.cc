// A rig that keeps its speed by itself, and what it takes orders from.
#include "hardware/speed_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>

#include "core/types/plant_parameters.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/control_orders.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/test_bench.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

std::unique_ptr<Rig> MakeRig() {
  SimulatedRigOptions options;
  options.speed = 0.0;
  return MakeSimulatedRig(options);
}

/// `orders` by the sample after which they are given.
RunLog Played(Rig& rig,
              const RunPlan& plan,
              const std::map<std::int64_t, core::ControlOrder>& orders) {
  EXPECT_TRUE(rig.Arm(plan, kEpoch).ok());
  EXPECT_TRUE(rig.Start(kEpoch).ok());
  return Drain(rig, [&](const core::Sample& sample) {
    const auto order = orders.find(sample.index);
    if (order == orders.end()) return;
    const core::Status taken = rig.Command(kEpoch, Ordered(order->second));
    EXPECT_TRUE(taken.ok()) << (taken.ok() ? "" : taken.error().message);
  });
}

TEST(SpeedLoop, KeepsTheSpeedFromItsOrderOnAndStaysInsideTheEnvelope) {
  const auto rig = MakeRig();
  const RunPlan plan = ControlledPlan();
  const RunLog log = Played(*rig, plan, {{300, Order()}});
  ASSERT_EQ(log.samples.size(), static_cast<std::size_t>(kControlledSamples));
  const auto began = log.Of(RigEventKind::kControlBegan);
  ASSERT_EQ(began.size(), 1U);
  EXPECT_EQ(began[0].index, 301) << "the next sample after the order";
  for (std::size_t k = 0; k < 301; ++k) {
    EXPECT_NEAR(log.samples[k].uc_v, plan.uc_v[k], 1e-3) << "the plan is played until then";
  }
  const core::ReferencePlayer reference(plan.control->reference, plan.period_s);
  const core::Bench& bench = paper::Bench();
  const double rad_per_s = core::RadPerSecondOfRpm(bench.nominal.gear_ratio);
  for (std::size_t k = 450; k < log.samples.size(); ++k) {
    const core::Sample& sample = log.samples[k];
    const std::size_t tick = k - static_cast<std::size_t>(kControlFrom);
    EXPECT_LE(std::abs(sample.uc_v - log.samples[k - 1].uc_v),
              bench.limits.slew_v_per_s * plan.period_s + 1e-3);
    EXPECT_GE(sample.uc_v, bench.limits.uc_v_min - 1e-3);
    EXPECT_LE(sample.uc_v, bench.limits.uc_v_max + 1e-3);
    if (tick % 200 < 100) continue;  // it settles
    EXPECT_NEAR(sample.n_rpm * rad_per_s, reference.At(tick), 4.0) << k;
  }
}

TEST(SpeedLoop, GivesTheSameRunAgain) {
  const auto first = MakeRig();
  const auto second = MakeRig();
  const RunLog one = Played(*first, ControlledPlan(), {{300, Order()}, {500, Order(80.0)}});
  const RunLog two = Played(*second, ControlledPlan(), {{300, Order()}, {500, Order(80.0)}});
  ASSERT_EQ(one.samples.size(), two.samples.size());
  for (std::size_t k = 0; k < one.samples.size(); ++k) {
    ASSERT_EQ(one.samples[k].uc_v, two.samples[k].uc_v) << k;
    ASSERT_EQ(one.samples[k].n_rpm, two.samples[k].n_rpm) << k;
  }
}

TEST(SpeedLoop, WithoutAnOrderThePlanIsPlayed) {
  const auto rig = MakeRig();
  const RunPlan plan = ControlledPlan();
  const RunLog log = Played(*rig, plan, {});
  EXPECT_TRUE(log.Of(RigEventKind::kControlBegan).empty());
  for (std::size_t k = 0; k < plan.uc_v.size(); ++k) {
    EXPECT_NEAR(log.samples[k].uc_v, plan.uc_v[k], 1e-3);
  }
}

TEST(SpeedLoop, TellsWhatItMakesUpForAndWhyItEnds) {
  core::ControlOrder with_fault = Order();
  with_fault.alarmed = with_fault.named = true;
  core::DriveModel weaker = with_fault.healthy;
  weaker.speed.gain = 60.0;
  with_fault.believed = core::BelievedFault{paper::kR1, 56.0, weaker};
  const auto rig = MakeRig();
  // The rig is healthy: the speed refutes this diagnosis, and an order that repeats it says nothing
  // new.
  const RunLog log = Played(*rig,
                            ControlledPlan(),
                            {{200, Order()}, {400, with_fault}, {700, with_fault}, {800, Order()}});
  const auto made_up = log.Of(RigEventKind::kCompensated);
  ASSERT_EQ(made_up.size(), 1U);
  EXPECT_EQ(made_up[0].index, 401);
  EXPECT_EQ(made_up[0].component, paper::kR1);
  EXPECT_EQ(made_up[0].value, 56.0);
  const auto ended = log.Of(RigEventKind::kCompensationEnded);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_GT(ended[0].index, 401);
  EXPECT_LT(ended[0].index, 450);
  EXPECT_EQ(ended[0].text, "the speed refutes the diagnosis");
}

TEST(SpeedLoop, TriesADiagnosisOnWhatWasReadSinceTheAlarm) {
  core::ControlOrder alarm = Order();
  alarm.alarmed = true;
  core::ControlOrder wrong = alarm;
  wrong.named = true;
  core::DriveModel weaker = wrong.healthy;
  weaker.speed.gain = 60.0;
  wrong.believed = core::BelievedFault{paper::kR1, 56.0, weaker};
  const auto rig = MakeRig();
  const RunLog log =
      Played(*rig, ControlledPlan(), {{200, Order()}, {375, alarm}, {400, wrong}, {700, wrong}});
  EXPECT_TRUE(log.Of(RigEventKind::kCompensated).empty());
  const auto ended = log.Of(RigEventKind::kCompensationEnded);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].index, 401);
  EXPECT_EQ(ended[0].text, "the speed refutes the diagnosis");
}

TEST(SpeedLoop, RefusesWhatIsNotOfThisRunOrNoRig) {
  // It waits for its reader: it runs until it is stopped.
  SimulatedRigOptions options;
  options.speed = 0.0;
  options.queue_messages = 16;
  const auto rig = MakeSimulatedRig(options);
  EXPECT_FALSE(rig->Command(kEpoch, Ordered(Order())).ok()) << "it does not run";
  ASSERT_TRUE(rig->Arm(SquarePlan(50), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  EXPECT_EQ(rig->Command(kEpoch, Ordered(Order())).error().reason, "no_speed_control");
  rig->SafeStop("enough");
  (void)Drain(*rig);

  ASSERT_TRUE(rig->Arm(ControlledPlan(), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  for (const double gain : {0.0, -95.0, std::nan(""), HUGE_VAL}) {
    EXPECT_FALSE(rig->Command(kEpoch, Ordered(Order(gain))).ok()) << gain;
  }
  rig->SafeStop("enough");
  (void)Drain(*rig);

  RunPlan plan = ControlledPlan();
  plan.control->reference.hold_s = 0.01;
  EXPECT_EQ(rig->Arm(plan, kEpoch).error().field, "control/reference/hold_s");
}

}  // namespace
}  // namespace faultlab::hardware
