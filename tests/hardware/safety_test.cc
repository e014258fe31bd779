// Whatever happens, the bench ends with drive 0 and its relays nominal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <thread>

#include "tests/hardware/rig_runs.h"
#include "tests/hardware/test_bench.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

using core::Component;
using testing::HasSubstr;
RunPlan PlanWithFaults(int samples) {
  RunPlan plan = SquarePlan(samples);
  plan.faults = {{.component = paper::kR12, .value = 5600.0, .at_s = 0.1},
                 {.component = paper::kR1, .value = 10.0, .at_s = 0.2},
                 {.component = paper::kC8, .value = 1e-6, .at_s = 0.2}};
  return plan;
}

RunLog RunOf(TestBench& bench, const RunPlan& plan) {
  const core::Status armed = bench.rig->Arm(plan, kEpoch);
  EXPECT_TRUE(armed.ok()) << (armed.ok() ? "" : armed.error().message);
  EXPECT_TRUE(bench.rig->Start(kEpoch).ok());
  return Drain(*bench.rig);
}

RigLimits RestingFor(double seconds) {
  RigLimits limits = paper::Bench().limits;
  limits.relay_rest_s = seconds;
  return limits;
}

TEST(SafeStop, FollowsTheEndOfThePlan) {
  TestBench bench;
  const RunLog log = RunOf(bench, PlanWithFaults(60));
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
  EXPECT_EQ(log.Of(RigEventKind::kRelayConfirmed).size(), 3u);
  EXPECT_TRUE(bench.IsSafe());
}

TEST(SafeStop, FollowsAFailureAtTheNthCallForEveryN) {
  int calls = 0;
  {
    TestBench whole;
    (void)RunOf(whole, PlanWithFaults(30));
    calls = whole.journal.calls;
  }
  ASSERT_GT(calls, 100);
  int failed_runs = 0;
  for (int n = 0; n < calls; ++n) {
    TestBench bench;
    bench.journal.fail_at = n;
    const core::Status armed = bench.rig->Arm(PlanWithFaults(30), kEpoch);
    if (armed.ok()) {
      ASSERT_TRUE(bench.rig->Start(kEpoch).ok());
      const RunLog log = Drain(*bench.rig);
      if (log.events.back().kind == RigEventKind::kStopped) {
        ++failed_runs;
        EXPECT_EQ(bench.rig->state(), RigState::kTripped) << n;
        ASSERT_TRUE(bench.rig->trip().has_value()) << n;
        EXPECT_EQ(bench.rig->trip()->name, "io_error") << n;
        EXPECT_EQ(log.Of(RigEventKind::kTrip).size(), 1u) << n;
      }
    }
    EXPECT_TRUE(bench.IsSafe()) << "call " << n;
  }
  EXPECT_GT(failed_runs, 80);  // others hit arming or the safe stop
}

TEST(SafeStop, SaysSoWhenTheBoardDoesNotAnswerAtAll) {
  TestBench bench;
  ASSERT_TRUE(bench.rig->Arm(SquarePlan(50), kEpoch).ok());
  bench.journal.fail_at = bench.journal.calls + 20;
  bench.journal.failures = 1'000'000;
  ASSERT_TRUE(bench.rig->Start(kEpoch).ok());
  const RunLog log = Drain(*bench.rig);
  EXPECT_EQ(bench.rig->state(), RigState::kTripped);
  EXPECT_THAT(log.last_text(), HasSubstr("drive 0 failed"));
  EXPECT_THAT(log.last_text(), HasSubstr("relays nominal failed"));
  EXPECT_EQ(log.events.back().value, 0.0) << "drive 0 was not reached";
}

TEST(SafeStop, FollowsSilenceOfTheHolder) {
  TestBench bench(TestBenchOptions{.clock = nullptr,
                                   .watchdog = std::chrono::milliseconds(500),
                                   .limits = paper::Bench().limits,
                                   .wait_for_reader = false,
                                   .queue_messages = 1u << 20});
  ASSERT_TRUE(bench.rig->Arm(SquarePlan(1'000'000), kEpoch).ok());
  ASSERT_TRUE(bench.rig->Start(kEpoch).ok());
  bench.wall->Advance(std::chrono::milliseconds(400));
  bench.rig->KeepAlive(kEpoch);
  bench.wall->Advance(std::chrono::milliseconds(400));
  EXPECT_EQ(bench.rig->state(), RigState::kRunning);
  bench.wall->Advance(std::chrono::milliseconds(101));
  while (bench.rig->state() == RigState::kRunning) std::this_thread::yield();
  const RunLog log = Drain(*bench.rig);
  EXPECT_THAT(log.last_text(), HasSubstr("watchdog"));
  EXPECT_NEAR(log.events.back().value, 0.507, 1e-9) << "501 ms of silence, 6 ms of relays";
  EXPECT_TRUE(bench.IsSafe());
}

TEST(SafeStop, FollowsAFullQueue) {
  TestBench bench(TestBenchOptions{.clock = nullptr,
                                   .watchdog = {},
                                   .limits = paper::Bench().limits,
                                   .wait_for_reader = false,
                                   .queue_messages = 8});
  ASSERT_TRUE(bench.rig->Arm(SquarePlan(100), kEpoch).ok());
  ASSERT_TRUE(bench.rig->Start(kEpoch).ok());
  while (bench.rig->state() == RigState::kRunning) std::this_thread::yield();
  const RunLog log = Drain(*bench.rig);  // ends after the rig is safe
  EXPECT_TRUE(bench.IsSafe());
  EXPECT_THAT(log.last_text(), HasSubstr("queue full"));
  EXPECT_EQ(log.samples.size(), 7u);  // kStarted is the eighth
}

TEST(SafeStop, FollowsTooManyLateTicksInARow) {
  const auto clock = std::make_shared<StumblingClock>(
      [](int sleep) { return std::chrono::milliseconds(sleep >= 40 ? 25 : 0); });
  TestBench bench(
      TestBenchOptions{.clock = clock, .watchdog = {}, .limits = paper::Bench().limits});
  const RunLog log = RunOf(bench, SquarePlan(200));
  EXPECT_THAT(log.last_text(), HasSubstr("overrun"));
  EXPECT_EQ(log.Of(RigEventKind::kOverrun).size(), 5u);
  EXPECT_TRUE(bench.IsSafe());
  EXPECT_EQ(bench.rig->loop_quality().overruns, 5u);
  EXPECT_EQ(bench.rig->loop_quality().missed_ticks, 10u);
}

TEST(SafeStop, MayComeFromOutsideWhileTheLoopWaitsForItsReader) {
  TestBench bench;
  ASSERT_TRUE(bench.rig->Arm(PlanWithFaults(500), kEpoch).ok());
  ASSERT_TRUE(bench.rig->Start(kEpoch).ok());
  bench.rig->SafeStop("enough");
  EXPECT_TRUE(bench.IsSafe());
  EXPECT_EQ(bench.rig->state(), RigState::kIdle);
  EXPECT_EQ(Drain(*bench.rig).last_text(), "enough");
}

TEST(Overrun, OfOneTickMovesTheGridAndTellsTheTruthAboutTime) {
  const auto clock = std::make_shared<StumblingClock>(
      [](int sleep) { return std::chrono::milliseconds(sleep == 41 ? 25 : 0); });
  TestBench bench(
      TestBenchOptions{.clock = clock, .watchdog = {}, .limits = paper::Bench().limits});
  const RunLog log = RunOf(bench, SquarePlan(100));
  ASSERT_EQ(log.samples.size(), 100u);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
  ASSERT_EQ(log.Of(RigEventKind::kOverrun).size(), 1u);
  EXPECT_DOUBLE_EQ(log.Of(RigEventKind::kOverrun)[0].value, 0.025);
  EXPECT_NEAR(log.samples.back().t_s, 0.99 + 0.02, 1e-9);
  for (std::size_t k = 1; k < log.samples.size(); ++k) {
    EXPECT_GE(log.samples[k].t_s - log.samples[k - 1].t_s, 0.005) << "no rush after the stumble";
  }
}

TEST(Relays, HangOnLinesThatComeInFours) {
  // Paper Table 2, where "Do156 ohm" of R1 means Do1, 56 ohm.
  const RelayWiring wiring = WiringOf(paper::Bench());
  const auto lines_of = [](core::Component board) {
    std::array<int, 4> lines{};
    for (std::size_t i = 0; i < lines.size(); ++i) lines[i] = board.info().positions.at(i).line;
    return lines;
  };
  EXPECT_EQ(lines_of(paper::kR1), (std::array<int, 4>{17, 16, 1, 0}));
  EXPECT_EQ(paper::RelayValues(paper::kR1)[2], 56.0);
  std::set<std::array<int, 4>> fours;
  for (const core::Component board : wiring.boards) {
    std::array<int, 4> lines = lines_of(board);
    std::sort(lines.begin(), lines.end());
    fours.insert(lines);
  }
  EXPECT_EQ(fours,
            (std::set<std::array<int, 4>>{
                {0, 1, 16, 17}, {2, 3, 18, 19}, {4, 5, 20, 21}, {6, 7, 22, 23}}));
  EXPECT_EQ(wiring.mask(), 0x00ff00ffu) << "24 lines suffice";
}

TEST(Relays, AreSwitchedInTheOrderThatEachBoardNeeds) {
  TestBench bench;
  RunPlan plan = SquarePlan(400);
  double at_s = 0.1;
  for (const Component component : WiringOf(paper::Bench()).boards) {
    for (const double value : paper::RelayValues(component)) {
      plan.faults.push_back({.component = component, .value = value, .at_s = at_s});
      at_s += 0.1;
    }
  }
  const RunLog log = RunOf(bench, plan);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished) << log.last_text();
  EXPECT_EQ(log.Of(RigEventKind::kRelayConfirmed).size(), 12u);  // none for nominal to nominal
  EXPECT_EQ(bench.daq->abuse().two_connected, 0);
  EXPECT_EQ(bench.daq->abuse().left_open, 0);
  bool both_r12 = false;
  for (const std::uint32_t levels : bench.journal.levels) {
    both_r12 = both_r12 || ((~levels & (1u << 6)) != 0 && (~levels & (1u << 7)) != 0);
  }
  EXPECT_TRUE(both_r12) << "R12 makes before it breaks";
}

TEST(Relays, ThatReadBackOtherwiseTripAndTheTripLatches) {
  TestBench bench;
  ASSERT_TRUE(bench.rig->Arm(PlanWithFaults(100), kEpoch).ok());
  ASSERT_TRUE(bench.rig->Start(kEpoch).ok());
  RunLog log;
  bench.journal.stuck_low = 0;
  const RunLog run = Drain(*bench.rig, [&](const core::Sample& sample) {
    // Do1 (R1 = 56 ohm) closes by itself.
    if (sample.index == 2) bench.journal.stuck_low = 1u << 1;
  });
  EXPECT_EQ(bench.rig->state(), RigState::kTripped);
  ASSERT_EQ(run.Of(RigEventKind::kTrip).size(), 1u);
  EXPECT_THAT(run.Of(RigEventKind::kTrip)[0].text, HasSubstr("Do1)"));
  EXPECT_EQ(bench.rig->Arm(SquarePlan(10), kEpoch).error().code, core::ErrorCode::kConflict);
  const RigCommand clear{.kind = RigCommand::Kind::kClearTrip};
  EXPECT_FALSE(bench.rig->Command(kEpoch, clear).ok()) << "still stuck";
  bench.journal.stuck_low = 0;
  EXPECT_TRUE(bench.rig->Command(kEpoch, clear).ok());
  EXPECT_EQ(bench.rig->state(), RigState::kIdle);
  EXPECT_EQ(RunOf(bench, SquarePlan(10)).samples.size(), 10u);
}

TEST(Relays, RestBetweenTwoSwitchingsAndTheNewestCommandWins) {
  TestBench bench(TestBenchOptions{
      .clock = nullptr, .watchdog = {}, .limits = RestingFor(0.5), .queue_messages = 4});
  ASSERT_TRUE(bench.rig->Arm(SquarePlan(200), kEpoch).ok());
  ASSERT_TRUE(bench.rig->Start(kEpoch).ok());
  const RunLog log = Drain(*bench.rig, [&](const core::Sample& sample) {
    const auto set = [&](double value) {
      EXPECT_TRUE(bench.rig
                      ->Command(kEpoch,
                                {.kind = RigCommand::Kind::kSetComponent,
                                 .component = paper::kR1,
                                 .value = value})
                      .ok());
    };
    if (sample.index == 20) set(10.0);
    if (sample.index == 40) set(56.0);
    if (sample.index == 50) set(100.0);
  });
  const auto confirmed = log.Of(RigEventKind::kRelayConfirmed);
  ASSERT_EQ(confirmed.size(), 2u);
  EXPECT_EQ(confirmed[0].value, 10.0);
  EXPECT_EQ(confirmed[1].value, 100.0);
  EXPECT_GE(confirmed[1].index - confirmed[0].index, 50);
  ASSERT_EQ(log.Of(RigEventKind::kRefused).size(), 1u);
  EXPECT_EQ(log.Of(RigEventKind::kRefused)[0].value, 56.0);
}

TEST(Relays, OfABenchTakeTableValuesOnly) {
  TestBench bench;
  RunPlan plan = SquarePlan(10);
  plan.faults = {{.component = paper::kR1, .value = 12.0}};
  EXPECT_THAT(bench.rig->Arm(plan, kEpoch).error().message, HasSubstr("1, 10, 56, 100"));
  plan.faults = {{.component = paper::kJ, .value = 1e-6}};
  EXPECT_EQ(bench.rig->Arm(plan, kEpoch).error().field, "faults/0/value");
  plan.faults = {{.component = paper::kR9,
                  .value = 33e3,
                  .at_s = 1.0,
                  .kind = core::FaultKind::kDrift,
                  .until_s = 2.0}};
  EXPECT_EQ(bench.rig->Arm(plan, kEpoch).error().field, "faults/0/kind");
}

TEST(SelfTest, NamesThePositionThatDoesNotAnswer) {
  TestBench bench;
  EXPECT_TRUE(bench.rig->SelfTest(kEpoch).value().ok);
  bench.journal.stuck_low = 1u << 22;  // R12 = 3.3 kohm sticks: seen at every position
  const SelfTestReport report = bench.rig->SelfTest(kEpoch).value();
  EXPECT_FALSE(report.ok);
  EXPECT_EQ(report.positions.size(), 16u);
  bench.journal.stuck_low = 0;
  EXPECT_TRUE(bench.rig->SelfTest(kEpoch).value().ok);
  EXPECT_TRUE(bench.IsSafe());
}

// ---- interlocks ---------------------------------------------------------------------------------

core::Sample Reading(std::int64_t k, double ia_a, double n_rpm = 500.0) {
  return {.index = k,
          .t_s = static_cast<double>(k) * 0.01,
          .uc_v = 2.0,
          .um_v = 5.0,
          .ua_v = 5.0,
          .ia_a = ia_a,
          .n_rpm = n_rpm};
}

std::optional<Trip> Feed(Interlocks& interlocks,
                         double ia_a,
                         double seconds,
                         double n_rpm = 500.0) {
  for (std::int64_t k = 0; k < std::llround(seconds * 100.0); ++k) {
    if (auto trip = interlocks.Check(Reading(k, ia_a, n_rpm), 0.01)) return trip;
  }
  return std::nullopt;
}

TEST(Interlocks, LetTheContinuousCurrentFlowForEver) {
  Interlocks interlocks{paper::Bench().limits};
  EXPECT_FALSE(Feed(interlocks, 0.628, 600.0).has_value());
}

TEST(Interlocks, TripOnHeatWhenTheFirstOrderModelSays) {
  Interlocks interlocks{paper::Bench().limits};
  const std::optional<Trip> trip = Feed(interlocks, 1.0, 60.0);
  ASSERT_TRUE(trip.has_value());
  EXPECT_EQ(trip->name, "over_heat");
  // theta = i^2 (1 - exp(-t/tau)) reaches 0.629^2 at t = -tau ln(1 - 0.629^2).
  const double expected_s = -12.0 * std::log(1.0 - 0.629 * 0.629);
  EXPECT_NEAR(trip->t_s, expected_s, 0.02);
  EXPECT_GT(trip->value, trip->limit);
}

TEST(Interlocks, ForgetHeatOnlyAsTheWindingDoes) {
  Interlocks interlocks{paper::Bench().limits};
  EXPECT_FALSE(Feed(interlocks, 1.0, 5.0).has_value());
  const double hot = interlocks.heat();
  interlocks.StartRun();
  EXPECT_EQ(interlocks.heat(), hot);
  interlocks.Rest(12.0);
  EXPECT_NEAR(interlocks.heat(), hot * std::exp(-1.0), 1e-12);
}

TEST(Interlocks, TripOnOneSampleAboveThePeak) {
  Interlocks interlocks{paper::Bench().limits};
  const auto trip = interlocks.Check(Reading(7, -1.95), 0.01);
  ASSERT_TRUE(trip.has_value());
  EXPECT_EQ(trip->name, "over_current");
  EXPECT_DOUBLE_EQ(trip->value, 1.95);
  EXPECT_EQ(trip->index, 7);
}

TEST(Interlocks, TripOnAMotorThatStandsUnderCurrentButNotOnOneThatStarts) {
  Interlocks interlocks{paper::Bench().limits};
  EXPECT_FALSE(Feed(interlocks, 0.6, 0.4, 0.0).has_value());
  EXPECT_FALSE(Feed(interlocks, 0.6, 0.1, 50.0).has_value());
  const auto trip = Feed(interlocks, 0.6, 1.0, 0.0);
  ASSERT_TRUE(trip.has_value());
  EXPECT_EQ(trip->name, "stall");
  EXPECT_NEAR(trip->t_s, 0.5, 0.02);
}

TEST(Interlocks, TripOnVoltageAndIgnoreChannelsThatAreNotThere) {
  Interlocks interlocks{paper::Bench().limits};
  core::Sample sample = Reading(0, core::kAbsent, core::kAbsent);
  EXPECT_FALSE(interlocks.Check(sample, 0.01).has_value());
  sample.ua_v = 12.7;
  EXPECT_EQ(interlocks.Check(sample, 0.01)->name, "over_voltage");
}

TEST(Interlocks, EndARunInASafeStopWithNameValueAndTime) {
  RigLimits limits = paper::Bench().limits;
  limits.current_peak_a = 0.2;
  TestBench bench(TestBenchOptions{.clock = nullptr, .watchdog = {}, .limits = limits});
  const RunLog log = RunOf(bench, SquarePlan(100));
  ASSERT_EQ(log.Of(RigEventKind::kTrip).size(), 1u);
  EXPECT_THAT(log.Of(RigEventKind::kTrip)[0].text, HasSubstr("over_current: motor current"));
  EXPECT_GT(log.Of(RigEventKind::kTrip)[0].value, 0.2);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kStopped);
  EXPECT_EQ(bench.rig->state(), RigState::kTripped);
  EXPECT_TRUE(bench.IsSafe());
}

TEST(Envelope, RefusesAStepSteeperThanTheSlew) {
  RigLimits limits = paper::Bench().limits;
  limits.slew_v_per_s = 200.0;
  TestBench bench(TestBenchOptions{.clock = nullptr, .watchdog = {}, .limits = limits});
  RunPlan plan;
  plan.uc_v = {2.0, 3.0, 5.0, 2.9};
  const core::Status refused = bench.rig->Arm(plan, kEpoch);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "uc_v/3");
}

}  // namespace
}  // namespace faultlab::hardware
