// Whole runs of the firmware in simavr, and what may happen to them. In lockstep: times are the
// device's, whatever the machine does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/plant/simulate_record.h"
#include "tests/device/device_rigs.h"
#include "tests/hardware/rig_runs.h"

namespace faultlab::hardware {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr Epoch kEpoch{1};

double Milliseconds(Nanoseconds time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

class DeviceRun : public testing::Test {
 protected:
  RunLog Run(const RunPlan& plan, const std::function<void(const core::Sample&)>& on_sample = {}) {
    const core::Status armed = rig_->Arm(plan, kEpoch);
    EXPECT_TRUE(armed.ok()) << (armed.ok() ? "" : armed.error().message);
    if (!armed.ok()) return {};
    EXPECT_TRUE(rig_->Start(kEpoch).ok());
    return Drain(*rig_, on_sample);
  }
  /// A run in which `what` happens at sample 50; nothing of it is needed for long.
  RunLog RunWith(const std::function<void()>& what) {
    return Run(SquarePlan(400), [&](const core::Sample& sample) {
      if (sample.index == 50) what();
    });
  }

  SimulatedDevice device_{SimulatedDevice::Line::kSerialServer};
  std::unique_ptr<PacedRig> rig_ = MakeLockstepRig(device_);
};

RunPlan PlanWithFault() {
  RunPlan plan = SquarePlan(400);
  plan.faults = {{.component = paper::kR1, .value = 10.0, .at_s = 1.0}};
  return plan;
}

TEST_F(DeviceRun, SeesWhatTheSimulatorOfTheSameBenchSays) {
  const RunPlan plan = PlanWithFault();
  const RunLog log = Run(plan);
  ASSERT_EQ(log.samples.size(), plan.uc_v.size()) << log.last_text();
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
  ASSERT_EQ(log.Of(RigEventKind::kFaultCommanded).size(), 1u);
  ASSERT_EQ(log.Of(RigEventKind::kRelayConfirmed).size(), 1u);
  EXPECT_EQ(log.Of(RigEventKind::kFaultCommanded)[0].index, 100);
  EXPECT_EQ(log.Of(RigEventKind::kRelayConfirmed)[0].index, 100);

  core::BenchProfile quiet = paper::Hardware();
  quiet.noise = {};
  const std::vector<core::Sample> expected =
      core::SimulateRecord(quiet, paper::Plant(), plan.uc_v, plan.faults, 1, plan.period_s);
  double um_squares = 0.0;
  double n_squares = 0.0;
  int compared = 0;
  for (std::size_t k = 5; k < expected.size(); ++k) {
    const core::Sample& seen = log.samples[k];
    EXPECT_NEAR(seen.uc_v, expected[k].uc_v, 0.7e-3) << k;  // half a step of 12 bit
    if (k >= 100 && k < 110) continue;                      // the relays were open for their gap
    // 1 ms of delta would be 0.05 V rms here.
    EXPECT_NEAR(seen.um_v, expected[k].um_v, 0.08) << k;
    EXPECT_NEAR(seen.ua_v, expected[k].ua_v, 0.05) << k;
    EXPECT_NEAR(seen.ia_a, expected[k].ia_a, 0.02) << k;
    um_squares += std::pow(seen.um_v - expected[k].um_v, 2);
    n_squares += std::pow(seen.n_rpm - expected[k].n_rpm, 2);
    ++compared;
  }
  RecordProperty("um_rms_mv", std::to_string(1e3 * std::sqrt(um_squares / compared)));
  RecordProperty("n_rms_rpm", std::to_string(std::sqrt(n_squares / compared)));
  // simavr's converter rounds down and ends at 1023: 12 mV of this.
  EXPECT_LT(std::sqrt(um_squares / compared), 0.02);
  EXPECT_LT(std::sqrt(n_squares / compared), 6.0);
}

TEST_F(DeviceRun, SwitchesEveryRelayInTheOrderThatItsBoardNeeds) {
  RunPlan plan = SquarePlan(400);
  double at_s = 0.0;
  for (const core::Component component : WiringOf(paper::Bench()).boards) {
    for (const double value : paper::RelayValues(component)) {
      at_s += 0.1;
      plan.faults.push_back({.component = component, .value = value, .at_s = at_s});
    }
  }
  // Two boards at once.
  plan.faults.push_back({.component = paper::kR9, .value = 33e3, .at_s = 3.0});
  plan.faults.push_back({.component = paper::kR12, .value = 5600.0, .at_s = 3.0});
  const RunLog log = Run(plan);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished) << log.last_text();
  const auto confirmed = log.Of(RigEventKind::kRelayConfirmed);
  ASSERT_EQ(confirmed.size(), 14u);
  EXPECT_EQ(confirmed[12].index, 300);
  EXPECT_EQ(confirmed[13].index, 300);
  EXPECT_EQ(device_.abuse().two_connected, 0);
  EXPECT_EQ(device_.abuse().left_open, 0);
  EXPECT_TRUE(device_.IsSafe());
}

TEST_F(DeviceRun, ObeysALiveCommand) {
  const RunLog log = RunWith([&] {
    EXPECT_TRUE(
        rig_->Command(
                kEpoch,
                {.kind = RigCommand::Kind::kSetComponent, .component = paper::kR9, .value = 33e3})
            .ok());
  });
  ASSERT_EQ(log.Of(RigEventKind::kRelayConfirmed).size(), 1u) << log.last_text();
  // 60 ms ahead of the device, which is some samples ahead of this test.
  EXPECT_GE(log.Of(RigEventKind::kRelayConfirmed)[0].index, 57);
  EXPECT_LE(log.Of(RigEventKind::kRelayConfirmed)[0].index, 70);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
}

TEST_F(DeviceRun, SaysInWhichDirectionTheMotorTurns) {
  const RunLog forwards = Run(SquarePlan(100));
  ASSERT_EQ(forwards.samples.size(), 100u);
  EXPECT_GT(forwards.samples.back().n_rpm, 300.0);
  device_.SwapEncoder();
  const RunLog backwards = Run(SquarePlan(100));
  ASSERT_EQ(backwards.samples.size(), 100u);
  EXPECT_NEAR(backwards.samples.back().n_rpm, -forwards.samples.back().n_rpm, 20.0);
}

TEST_F(DeviceRun, EndsWhenTheCableIsCutAndTheDeviceIsSafeByItself) {
  Nanoseconds cut_at{0};
  const RunLog log = RunWith([&] { cut_at = device_.CutCable(true); });
  EXPECT_EQ(rig_->state(), RigState::kTripped);
  EXPECT_EQ(rig_->trip()->name, "device_lost");
  EXPECT_THAT(log.last_text(), HasSubstr("drive 0 is not confirmed"));
  EXPECT_TRUE(device_.IsSafe());
  const double zero_ms = Milliseconds(device_.drive_zero_at() - cut_at);
  RecordProperty("cut_to_zero_ms", std::to_string(zero_ms));
  EXPECT_GT(zero_ms, 150.0) << "the watchdog of 250 ms, not something else";
  EXPECT_LT(zero_ms, 260.0);

  // With the cable back the rig is cleared, and runs.
  const RigCommand clear{.kind = RigCommand::Kind::kClearTrip};
  EXPECT_FALSE(rig_->Command(kEpoch, clear).ok()) << "still cut";
  device_.CutCable(false);
  ASSERT_TRUE(rig_->Command(kEpoch, clear).ok());
  EXPECT_EQ(Run(SquarePlan(50)).samples.size(), 50u);
}

TEST_F(DeviceRun, EndsAtOnceWhenTheLineIsClosed) {
  const RunLog log = RunWith([&] { device_.HangUp(); });
  EXPECT_EQ(rig_->trip()->name, "device_lost");
  EXPECT_THAT(log.last_text(), HasSubstr("closed by the other side"));
  device_.RunUntil(device_.now() + milliseconds(300));
  EXPECT_TRUE(device_.IsSafe());
}

TEST_F(DeviceRun, EndsWhenTheDeviceIsResetInMidRun) {
  Nanoseconds reset_at{0};
  double before_v = 0.0;
  const RunLog log = RunWith([&] {
    before_v = device_.drive_v();
    reset_at = device_.PressReset();
  });
  EXPECT_GT(before_v, 1.0);
  EXPECT_EQ(rig_->trip()->name, "device_reset");
  EXPECT_THAT(log.last_text(), HasSubstr("started anew in mid-run"));
  EXPECT_TRUE(device_.IsSafe());
  const double zero_ms = Milliseconds(device_.drive_zero_at() - reset_at);
  RecordProperty("reset_to_zero_ms", std::to_string(zero_ms));
  EXPECT_LT(zero_ms, 5.0);
  ASSERT_TRUE(rig_->Command(kEpoch, {.kind = RigCommand::Kind::kClearTrip}).ok());
  EXPECT_EQ(Run(SquarePlan(50)).samples.size(), 50u);
}

TEST_F(DeviceRun, LosesNothingToANoisyLine) {
  RunPlan plan = SquarePlan(1000);
  plan.faults = {{.component = paper::kR9, .value = 33e3, .at_s = 5.0}};
  ASSERT_TRUE(rig_->Arm(plan, kEpoch).ok());
  device_.SetNoise(1e-3);
  ASSERT_TRUE(rig_->Start(kEpoch).ok());
  const RunLog log = Drain(*rig_);
  ASSERT_EQ(log.samples.size(), plan.uc_v.size()) << log.last_text();
  for (std::size_t k = 0; k < log.samples.size(); ++k) {
    EXPECT_EQ(log.samples[k].index, static_cast<std::int64_t>(k));
  }
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
  EXPECT_EQ(log.Of(RigEventKind::kRelayConfirmed).size(), 1u);
  EXPECT_GT(device_.noise_hits(), 30);
}

TEST_F(DeviceRun, IgnoresGarbageOnTheLine) {
  std::string garbage;
  std::uint32_t state = 99;
  for (int i = 0; i < 2000; ++i) {
    state = state * 1664525u + 1013904223u;
    garbage.push_back(static_cast<char>(state >> 24));
  }
  const RunLog log = Run(SquarePlan(400), [&](const core::Sample& sample) {
    if (sample.index % 20 != 10) return;
    const auto from = static_cast<std::size_t>(sample.index * 4);
    device_.InjectToDevice(garbage.substr(from, 80));
    device_.InjectToHost(garbage.substr(from, 80));
  });
  EXPECT_EQ(log.samples.size(), 400u) << log.last_text();
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished) << log.last_text();
}

TEST_F(DeviceRun, EndsWhenTheLineIsNothingButNoise) {
  const RunLog log = RunWith([&] { device_.SetNoise(0.3); });
  EXPECT_EQ(rig_->trip()->name, "device_lost");
  EXPECT_LT(log.samples.size(), 400u);
  device_.RunUntil(device_.now() + milliseconds(300));
  EXPECT_TRUE(device_.IsSafe());
}

TEST_F(DeviceRun, EndsWhenTheDeviceFloodsItsLineAndNamesIt) {
  Nanoseconds flooded_at{0};
  const RunLog log = RunWith([&] {
    flooded_at = device_.now();
    device_.InjectToHost(std::string(8 << 20, 'U'));
  });
  EXPECT_EQ(rig_->trip()->name, "device_lost");
  EXPECT_THAT(log.last_text(), HasSubstr("floods its line"));
  EXPECT_LT(log.samples.size(), 400u);
  device_.RunUntil(device_.now() + milliseconds(300));
  EXPECT_TRUE(device_.IsSafe());
  EXPECT_LT(Milliseconds(device_.drive_zero_at() - flooded_at), 400.0);
}

TEST_F(DeviceRun, EndsWhenARelaySticksAndNamesItsLine) {
  // Do1, R1 = 56 ohm, closes by itself.
  const RunLog log = RunWith([&] { device_.StickLines(1u << 1); });
  EXPECT_EQ(rig_->trip()->name, "relay_readback");
  EXPECT_THAT(log.last_text(), HasSubstr("Do1)"));
  EXPECT_EQ(device_.drive_v(), 0.0);
  const RigCommand clear{.kind = RigCommand::Kind::kClearTrip};
  const core::Status stuck = rig_->Command(kEpoch, clear);
  ASSERT_FALSE(stuck.ok());
  EXPECT_THAT(stuck.error().message, HasSubstr("Do1)"));
  device_.StickLines(0);
  ASSERT_TRUE(rig_->Command(kEpoch, clear).ok());
  EXPECT_EQ(Run(SquarePlan(50)).samples.size(), 50u);
}

TEST_F(DeviceRun, FindsAStuckRelayInTheSelfTest) {
  device_.StickLines(1u << 22);
  const SelfTestReport report = rig_->SelfTest(kEpoch).value();
  EXPECT_FALSE(report.ok);
  ASSERT_EQ(report.positions.size(), 16u);
  EXPECT_THAT(report.positions[0].text, HasSubstr("Do22)"));
  device_.StickLines(0);
  EXPECT_TRUE(rig_->SelfTest(kEpoch).value().ok);
  EXPECT_TRUE(device_.IsSafe());
}

TEST(DeviceLimits, GuardADeviceLikeAnyRig) {
  SimulatedDevice device(SimulatedDevice::Line::kSerialServer);
  BenchConfig config = DeviceBenchConfig();
  config.limits.current_peak_a = 0.3;
  const auto rig = MakeLockstepRig(device, config);
  ASSERT_TRUE(rig->Arm(SquarePlan(100), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  const RunLog log = Drain(*rig);
  ASSERT_EQ(log.Of(RigEventKind::kTrip).size(), 1u);
  EXPECT_THAT(log.Of(RigEventKind::kTrip)[0].text, HasSubstr("over_current"));
  EXPECT_TRUE(device.IsSafe());

  RunPlan plan = SquarePlan(10);
  plan.period_s = 0.1;
  ASSERT_TRUE(rig->Command(kEpoch, {.kind = RigCommand::Kind::kClearTrip}).ok());
  EXPECT_THAT(rig->Arm(plan, kEpoch).error().message, HasSubstr("2 ms to 32 ms"));
}

TEST(DeviceLimits, RefuseADeviceThatIsWiredOtherwise) {
  SimulatedDevice device(SimulatedDevice::Line::kSerialServer);
  BenchConfig config = DeviceBenchConfig();
  config.wiring.boards.pop_back();
  try {
    (void)MakeLockstepRig(device, config);
    FAIL() << "its relay lines are others";
  } catch (const IoError& error) {
    EXPECT_THAT(error.what(), HasSubstr("relay lines 0x00ff00ff"));
  }
}

}  // namespace
}  // namespace faultlab::hardware
