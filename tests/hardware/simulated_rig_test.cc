#include "hardware/simulated/simulated_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "core/plant/converters.h"
#include "core/plant/simulate_record.h"
#include "hardware/bench/benches.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/test_bench.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

constexpr double kConverterStepV = 2.0 * 10.0 / core::kConverterSteps;

using core::Component;
SimulatedRigOptions Fast() {
  SimulatedRigOptions options;
  options.speed = 0.0;
  return options;
}

RunLog RunOf(Rig& rig, const RunPlan& plan) {
  EXPECT_TRUE(rig.Arm(plan, kEpoch).ok());
  EXPECT_TRUE(rig.Start(kEpoch).ok());
  return Drain(rig);
}

TEST(SimulatedRig, ReadsWhatCoresPlantSaysWithinOneStepOfItsConverters) {
  const auto rig = MakeSimulatedRig(Fast());
  RunPlan plan = SquarePlan(2000);
  plan.seed = 42;
  plan.faults = {{.component = paper::kR1, .value = 100.0, .at_s = 10.0},
                 {.component = paper::kRa, .value = 14.0, .at_s = 15.0}};
  const RunLog log = RunOf(*rig, plan);
  const std::vector<core::Sample> expected = core::SimulateRecord(
      paper::Hardware(), paper::Plant(), plan.uc_v, plan.faults, plan.seed, paper::kPeriodS);
  ASSERT_EQ(log.samples.size(), expected.size());
  // um passes a 2:1 divider on one rig and none on the other: half a step of each converter.
  constexpr double kUmStep = 1.5 * kConverterStepV + 1e-9;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(log.samples[k].t_s, expected[k].t_s);
    EXPECT_EQ(log.samples[k].uc_v, expected[k].uc_v);
    ASSERT_NEAR(log.samples[k].um_v, expected[k].um_v, kUmStep) << k;
    ASSERT_NEAR(log.samples[k].ia_a, expected[k].ia_a, kConverterStepV / 5.0) << k;
    ASSERT_NEAR(log.samples[k].n_rpm, expected[k].n_rpm, 1e-6) << k;
  }
}

TEST(SimulatedRig, SeedDecidesTheNoise) {
  const auto rig = MakeSimulatedRig(Fast());
  RunPlan plan = SquarePlan(50);
  plan.seed = 1;
  const RunLog one = RunOf(*rig, plan);
  plan.seed = 2;
  const RunLog two = RunOf(*rig, plan);
  EXPECT_NE(one.samples[40].um_v, two.samples[40].um_v);
}

TEST(SimulatedRig, ScheduledFaultIsAnnouncedAndConfirmedAtItsSample) {
  const auto rig = MakeSimulatedRig(Fast());
  RunPlan plan = SquarePlan(200);
  plan.faults = {{.component = paper::kR12, .value = 3300.0, .at_s = 1.0}};
  const RunLog log = RunOf(*rig, plan);
  const auto commanded = log.Of(RigEventKind::kFaultCommanded);
  const auto confirmed = log.Of(RigEventKind::kRelayConfirmed);
  ASSERT_EQ(commanded.size(), 1u);
  ASSERT_EQ(confirmed.size(), 1u);
  EXPECT_EQ(commanded[0].index, 100);
  EXPECT_EQ(confirmed[0].index, 100);
  EXPECT_EQ(confirmed[0].component, paper::kR12);
  EXPECT_EQ(confirmed[0].value, 3300.0);
  // k falls from 2.4 to 1.06 from sample 100 on.
  EXPECT_GT(log.samples[99].ua_v / log.samples[99].uc_v, 2.3);
  EXPECT_LT(log.samples[100].ua_v / log.samples[100].uc_v, 1.2);
}

TEST(SimulatedRig, IntermittentFaultComesAndGoes) {
  const auto rig = MakeSimulatedRig(Fast());
  RunPlan plan = SquarePlan(300);
  plan.faults = {{.component = paper::kR9,
                  .value = 33e3,
                  .at_s = 1.0,
                  .kind = core::FaultKind::kIntermittent,
                  .until_s = 2.0}};
  const RunLog log = RunOf(*rig, plan);
  const auto confirmed = log.Of(RigEventKind::kRelayConfirmed);
  ASSERT_EQ(confirmed.size(), 2u);
  EXPECT_EQ(confirmed[0].index, 100);
  EXPECT_EQ(confirmed[0].value, 33e3);
  EXPECT_EQ(confirmed[1].index, 200);
  EXPECT_EQ(confirmed[1].value, 10e3);
}

TEST(SimulatedRig, DriftIsAnnouncedAtItsStartAndConfirmedAtItsEnd) {
  const auto rig = MakeSimulatedRig(Fast());
  RunPlan plan = SquarePlan(300);
  plan.faults = {{.component = paper::kRa,
                  .value = 20.0,
                  .at_s = 1.0,
                  .kind = core::FaultKind::kDrift,
                  .until_s = 2.0}};
  const RunLog log = RunOf(*rig, plan);
  const auto commanded = log.Of(RigEventKind::kFaultCommanded);
  const auto confirmed = log.Of(RigEventKind::kRelayConfirmed);
  ASSERT_EQ(commanded.size(), 1u);
  EXPECT_EQ(commanded[0].index, 100);
  EXPECT_EQ(commanded[0].value, 20.0);
  ASSERT_EQ(confirmed.size(), 1u);
  EXPECT_EQ(confirmed[0].index, 200);
  EXPECT_EQ(confirmed[0].value, 20.0);
}

TEST(SimulatedRig, LiveCommandActsAndSaysOnWhichSample) {
  SimulatedRigOptions options = Fast();
  options.queue_messages = 8;  // the rig cannot be far ahead of its reader
  const auto rig = MakeSimulatedRig(options);
  ASSERT_TRUE(rig->Arm(SquarePlan(400), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  const RunLog log = Drain(*rig, [&](const core::Sample& sample) {
    if (sample.index == 100) {
      EXPECT_TRUE(rig->Command(kEpoch,
                               {.kind = RigCommand::Kind::kSetComponent,
                                .component = paper::kR12,
                                .value = 2000.0})
                      .ok());
    }
  });
  const auto confirmed = log.Of(RigEventKind::kRelayConfirmed);
  ASSERT_EQ(confirmed.size(), 1u);
  const std::int64_t at = confirmed[0].index;
  EXPECT_GT(at, 100);
  EXPECT_LE(at, 120);
  const auto ratio = [&](std::int64_t k) {
    const core::Sample& sample = log.samples[static_cast<std::size_t>(k)];
    return sample.ua_v / sample.uc_v;
  };
  EXPECT_GT(ratio(at - 1), 2.3);
  EXPECT_LT(ratio(at), 0.9);
}

TEST(SimulatedRig, TakesValuesOffTheTableAndMotorFaultsLive) {
  SimulatedRigOptions options = Fast();
  options.queue_messages = 8;
  const auto rig = MakeSimulatedRig(options);
  ASSERT_TRUE(rig->Arm(SquarePlan(400), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  const RunLog log = Drain(*rig, [&](const core::Sample& sample) {
    const auto set = [&](Component component, double value) {
      EXPECT_TRUE(
          rig->Command(
                 kEpoch,
                 {.kind = RigCommand::Kind::kSetComponent, .component = component, .value = value})
              .ok());
    };
    if (sample.index == 50) set(paper::kR1, 17.5);
    if (sample.index == 100) set(paper::kJ, 5e-6);
    if (sample.index == 200) {
      EXPECT_TRUE(rig->Command(kEpoch, {}).ok());  // all nominal
    }
  });
  const auto confirmed = log.Of(RigEventKind::kRelayConfirmed);
  ASSERT_EQ(confirmed.size(), 4u);
  EXPECT_EQ(confirmed[0].value, 17.5);
  EXPECT_EQ(confirmed[1].value, 5e-6);
  EXPECT_EQ(confirmed[2].component, paper::kR1);
  EXPECT_EQ(confirmed[2].value, 1.0);
  EXPECT_EQ(confirmed[3].component, paper::kJ);
  EXPECT_EQ(confirmed[3].value, 1.43e-6);
}

TEST(SimulatedRig, RefusesWhatIsOutsideTheEnvelopeByName) {
  const auto rig = MakeSimulatedRig(Fast());
  const auto field = [&](const RunPlan& plan) {
    const core::Status refused = rig->Arm(plan, kEpoch);
    return refused.ok() ? std::string("accepted") : refused.error().field;
  };
  RunPlan plan = SquarePlan(10);
  plan.uc_v[4] = 5.01;
  EXPECT_EQ(field(plan), "uc_v/4");
  plan.uc_v[4] = -0.01;
  EXPECT_EQ(field(plan), "uc_v/4");
  plan.uc_v[4] = std::nan("");
  EXPECT_EQ(field(plan), "uc_v/4");
  plan = SquarePlan(10);
  plan.faults = {{.component = paper::kR1, .value = -1.0}};
  EXPECT_EQ(field(plan), "faults/0/value");
  plan.faults = {{.component = paper::kR1, .value = 10.0, .at_s = -1.0}};
  EXPECT_EQ(field(plan), "faults/0/at_s");
  plan.faults = {{.component = paper::kR1, .value = 10.0, .at_s = 1.0},
                 {.component = paper::kR1, .value = 56.0, .at_s = 1.02}};
  EXPECT_EQ(field(plan), "faults/0/at_s");
  plan = SquarePlan(0);
  EXPECT_EQ(field(plan), "uc_v");
}

TEST(SimulatedRig, FullVoltageFitsItsConverters) {
  const auto rig = MakeSimulatedRig(Fast());
  RunPlan plan;
  plan.uc_v.assign(300, 5.0);
  const RunLog log = RunOf(*rig, plan);
  ASSERT_EQ(log.samples.size(), 300u);
  EXPECT_NEAR(log.samples.back().ua_v, 12.0, 0.1);
}

TEST(SimulatedRig, GatedCountReadsTheMeanSpeedInWholePulses) {
  SimulatedRigOptions options = Fast();
  const RunLog frequency = RunOf(*MakeSimulatedRig(options), SquarePlan(300));
  options.gated_speed = true;
  const RunLog gated = RunOf(*MakeSimulatedRig(options), SquarePlan(300));
  constexpr double kQuantumRpm = 60.0 / (1000.0 * 3.8 * 0.01);
  double mean_difference = 0.0;
  for (std::size_t k = 200; k < 300; ++k) {
    const double pulses = gated.samples[k].n_rpm / kQuantumRpm;
    EXPECT_NEAR(pulses, std::round(pulses), 1e-6);
    mean_difference += (gated.samples[k].n_rpm - frequency.samples[k].n_rpm) / 100.0;
  }
  EXPECT_LT(std::abs(mean_difference), 5.0);
}

TEST(SimulatedRig, CurrentModeDrivesOneFifthAmperePerVolt) {
  SimulatedRigOptions options = Fast();
  options.bench = LoadBench("paper-current").value();
  const auto rig = MakeSimulatedRig(options);
  EXPECT_TRUE(rig->description().bench->structure->drives_current());
  RunPlan plan;
  plan.uc_v.assign(20, 0.5);
  const RunLog log = RunOf(*rig, plan);
  EXPECT_NEAR(log.samples[10].ia_a, 0.1, 2e-3);
}

TEST(SimulatedRig, TurnsBackwardsWhereItsBenchDoes) {
  std::string text = LoadBench("servo-motor").value()->text;
  const std::string one_way = "input_min_v = 0.0";
  text.replace(text.find(one_way), one_way.size(), "input_min_v = -5.0");
  SimulatedRigOptions options = Fast();
  options.bench = KeepBench(text, "both-ways.toml").value();
  const auto rig = MakeSimulatedRig(options);
  EXPECT_EQ(rig->description().amplifier_quadrants, core::Quadrants::kFour);
  EXPECT_EQ(rig->description().uc_v_min, -5.0);
  RunPlan plan;
  plan.period_s = options.bench->period_s;
  plan.uc_v.assign(200, -1.0);
  const RunLog log = RunOf(*rig, plan);
  ASSERT_EQ(log.samples.size(), 200u);
  EXPECT_LT(log.samples.back().n_rpm, -300.0);
}

TEST(SimulatedRig, FourQuadrantsTakeNegativeDriveAndTurnBackwards) {
  SimulatedRigOptions options = Fast();
  options.amplifier_quadrants = core::Quadrants::kFour;
  const auto rig = MakeSimulatedRig(options);
  EXPECT_EQ(rig->description().uc_v_min, -5.0);
  RunPlan plan;
  plan.uc_v.assign(200, -2.0);
  const RunLog log = RunOf(*rig, plan);
  ASSERT_EQ(log.samples.size(), 200u);
  EXPECT_LT(log.samples.back().um_v, -4.0);
  EXPECT_LT(log.samples.back().n_rpm, -300.0);
}

TEST(SimulatedRig, RealTimeRunFailsWhenNobodyReads) {
  SimulatedRigOptions options;
  options.speed = 1.0;
  options.queue_messages = 5;
  const auto rig = MakeSimulatedRig(options);
  ASSERT_TRUE(rig->Arm(SquarePlan(100), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  while (rig->state() == RigState::kRunning) {
    rig->KeepAlive(kEpoch);
    std::this_thread::yield();
  }
  const RunLog log = Drain(*rig);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kStopped);
  EXPECT_THAT(log.last_text(), testing::HasSubstr("queue full"));
  EXPECT_EQ(rig->state(), RigState::kIdle);
}

}  // namespace
}  // namespace faultlab::hardware
