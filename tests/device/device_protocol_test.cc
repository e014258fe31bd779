// What the firmware answers, request by request (hardware/device/PROTOCOL.md, sections 3 and 4). In
// simavr, in lockstep.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "hardware/device/device_port.h"
#include "hardware/io_error.h"
#include "tests/device/simulated_device.h"

namespace faultlab::hardware {
namespace {

using std::chrono::milliseconds;
using enum DeviceError;

constexpr std::uint32_t kOther = 1u << 16 | 1u << 19 | 1u << 21 | 1u << 6;  // R1 = 10 ohm

class DeviceProtocol : public testing::Test {
 protected:
  DeviceProtocol() { info_ = port_.Connect(std::chrono::seconds(1)); }

  DeviceError Ask(DeviceMessage message, const Payload& payload = {}) {
    return port_.AskFor(message, payload).error;
  }
  DeviceError Plan(std::uint32_t samples = 1000, std::uint32_t period_us = 10'000) {
    return Ask(DeviceMessage::kPlan, PlanPayload(samples, period_us, 9'000));
  }
  DeviceError Data(std::uint32_t first, std::size_t count, std::int16_t code = 2000) {
    return Ask(DeviceMessage::kData, DataPayload(first, std::vector<std::int16_t>(count, code)));
  }
  DeviceError Arm(std::uint16_t watchdog_ms = 250) {
    return Ask(DeviceMessage::kArm, ArmPayload(watchdog_ms, 3'000, 3'000));
  }
  DeviceError Relay(std::uint32_t at, std::uint32_t lines) {
    return Ask(DeviceMessage::kRelay, RelayPayload(at, lines));
  }
  DeviceAck Status() { return port_.AskFor(DeviceMessage::kHeartbeat); }
  void Pass(Nanoseconds time) { clock_->SleepUntil(clock_->Now() + time); }

  SimulatedDevice device_{SimulatedDevice::Line::kSerialServer};
  const std::shared_ptr<Clock> clock_ = device_.clock();
  DevicePort port_{{.port = device_.port()}, clock_};
  DeviceInfo info_;
};

TEST_F(DeviceProtocol, InfoSaysWhatTheBoardIs) {
  EXPECT_EQ(info_.version, kDeviceProtocol);
  EXPECT_EQ(info_.um.bits, 10);
  EXPECT_EQ(info_.relay_lines, 0x00ff00ffu);
  EXPECT_GE(info_.plan_values, 64);
  EXPECT_GE(info_.relay_entries, 8);
  EXPECT_EQ(info_.state, DeviceState::kSafe);
  EXPECT_NEAR(info_.uc.ToVolt(4095), 4.9988, 1e-3);
}

TEST_F(DeviceProtocol, RefusesAPlanThatItCannotKeep) {
  EXPECT_EQ(Plan(0), kRange);
  EXPECT_EQ(Plan(10, 1'000), kRange);
  EXPECT_EQ(Plan(10, 40'000), kRange);
  EXPECT_EQ(Ask(DeviceMessage::kPlan, PlanPayload(10, 10'000, 9'900)), kRange);
  EXPECT_EQ(Ask(DeviceMessage::kPlan, PlanPayload(10, 10'000, 100)), kRange);
  EXPECT_EQ(Plan(), kNone);
}

TEST_F(DeviceProtocol, TakesDataInOrderAndOnceOnly) {
  ASSERT_EQ(Plan(200), kNone);
  EXPECT_EQ(Data(1, 10), kOffset);
  EXPECT_EQ(Data(0, 10), kNone);
  EXPECT_EQ(Data(0, 10), kNone);
  EXPECT_EQ(Status().received, 10u);
  EXPECT_EQ(Data(4, 16), kNone) << "the end of it is new";
  EXPECT_EQ(Status().received, 20u);
  EXPECT_EQ(Data(20, 10, 4096), kRange);
  EXPECT_EQ(Data(20, 10, -1), kRange);
  std::uint32_t received = 20;
  while (received + 12 <= info_.plan_values) {
    ASSERT_EQ(Data(received, 12), kNone);
    received += 12;
  }
  EXPECT_EQ(Data(received, 12), kFull);
  EXPECT_EQ(Status().received, received);
  ASSERT_EQ(Plan(5), kNone);
  EXPECT_EQ(Data(0, 6), kRange) << "behind the end of the plan";
}

TEST_F(DeviceProtocol, KeepsItsStates) {
  EXPECT_EQ(Ask(DeviceMessage::kStart), kState);
  EXPECT_EQ(Relay(kRelayNow, kOther), kState);
  EXPECT_EQ(Arm(19), kRange);
  EXPECT_EQ(Arm(), kNone);
  EXPECT_EQ(Ask(DeviceMessage::kStart), kState) << "no plan";
  EXPECT_EQ(Plan(), kState) << "armed";
  EXPECT_EQ(Ask(DeviceMessage::kSafe), kNone);
  ASSERT_EQ(Plan(1000), kNone);
  ASSERT_EQ(Data(0, 24), kNone);
  ASSERT_EQ(Arm(), kNone);
  ASSERT_EQ(Ask(DeviceMessage::kStart), kNone);
  EXPECT_EQ(Ask(DeviceMessage::kStart), kNone) << "a repetition";
  EXPECT_EQ(Plan(), kState);
  EXPECT_EQ(Arm(), kState);
  Pass(milliseconds(50));
  EXPECT_GT(device_.drive_v(), 2.0);
  EXPECT_EQ(Ask(DeviceMessage::kSafe), kNone);
  EXPECT_EQ(device_.drive_v(), 0.0);
  EXPECT_EQ(Status().state, DeviceState::kSafe);
}

TEST_F(DeviceProtocol, RefusesWhatIsNoRequest) {
  EXPECT_EQ(Ask(static_cast<DeviceMessage>(0x0b)), kType);
  EXPECT_EQ(Ask(DeviceMessage::kPlan, Payload(11)), kLength);
  EXPECT_EQ(Ask(DeviceMessage::kData, Payload(7)), kLength);
  EXPECT_EQ(Ask(DeviceMessage::kSafe, Payload(1)), kLength);
}

TEST_F(DeviceProtocol, SwitchesRelaysOnTheirSample) {
  ASSERT_EQ(Plan(100), kNone);
  for (std::uint32_t first = 0; first < 96; first += 24) ASSERT_EQ(Data(first, 24), kNone);
  ASSERT_EQ(Arm(1000), kNone);
  EXPECT_EQ(Relay(20, 1u << 8), kRange) << "no relay is there";
  EXPECT_EQ(Relay(20, kOther), kNone);
  EXPECT_EQ(Relay(20, kOther), kNone) << "a repetition";
  EXPECT_EQ(Relay(20, BenchAtPins::kNominal), kOffset);
  EXPECT_EQ(Relay(30, BenchAtPins::kNominal), kNone);
  ASSERT_EQ(Ask(DeviceMessage::kStart), kNone);
  Pass(milliseconds(400));
  EXPECT_EQ(Relay(5, kOther), kOffset);
  EXPECT_EQ(Relay(31, kOther), kLate);
  port_.Poll();
  int other = 0;
  for (const DeviceSample& sample : port_.TakeSamples()) {
    const bool switched = sample.k >= 20 && sample.k < 30;
    EXPECT_EQ(sample.lines, switched ? kOther : BenchAtPins::kNominal) << sample.k;
    EXPECT_EQ(sample.flags, kRelaysSettled) << sample.k;
    EXPECT_EQ(sample.t_us, sample.k * 10'000);
    EXPECT_NEAR(sample.converted_us, 9'000.0, 60.0);
    other += switched ? 1 : 0;
  }
  EXPECT_EQ(other, 10);
}

TEST_F(DeviceProtocol, TakesAsManyRelayEntriesAsItSays) {
  ASSERT_EQ(Plan(100), kNone);
  ASSERT_EQ(Arm(), kNone);
  for (std::uint32_t i = 0; i < info_.relay_entries; ++i) ASSERT_EQ(Relay(i, kOther), kNone);
  EXPECT_EQ(Relay(90, kOther), kFull);
}

TEST_F(DeviceProtocol, SilenceInArmedAndInRunIsAFaultThatLatches) {
  for (const bool run : {false, true}) {
    ASSERT_EQ(Plan(), kNone);
    for (std::uint32_t first = 0; first < 120; first += 24) ASSERT_EQ(Data(first, 24), kNone);
    ASSERT_EQ(Arm(100), kNone);
    ASSERT_EQ(Relay(run ? 0 : kRelayNow, kOther), kNone);
    if (run) {
      ASSERT_EQ(Ask(DeviceMessage::kStart), kNone);
    }
    Pass(milliseconds(80));
    EXPECT_EQ(device_.lines(), kOther);
    EXPECT_EQ(device_.drive_v() > 1.0, run);
    Pass(milliseconds(40));
    EXPECT_TRUE(device_.IsSafe());
    const DeviceAck status = Status();
    EXPECT_EQ(status.state, DeviceState::kFault);
    EXPECT_EQ(status.fault, DeviceFault::kCommunication);
    EXPECT_EQ(Arm(), kState);
    EXPECT_EQ(Data(0, 1), kState);
    EXPECT_EQ(Ask(DeviceMessage::kSafe), kNone);
    EXPECT_EQ(Status().state, DeviceState::kFault);
    EXPECT_EQ(Ask(DeviceMessage::kClear), kNone);
    EXPECT_EQ(Status().state, DeviceState::kSafe);
  }
}

TEST_F(DeviceProtocol, ARelayThatMovesByItselfIsAFault) {
  ASSERT_EQ(Plan(), kNone);
  ASSERT_EQ(Data(0, 24), kNone);
  ASSERT_EQ(Arm(1000), kNone);
  ASSERT_EQ(Ask(DeviceMessage::kStart), kNone);
  Pass(milliseconds(50));
  device_.StickLines(1u << 1);
  Pass(milliseconds(30));
  EXPECT_EQ(Status().fault, DeviceFault::kRelay);
  EXPECT_EQ(device_.drive_v(), 0.0);
  EXPECT_EQ(Status().lines, BenchAtPins::kNominal | 1u << 1);
}

TEST_F(DeviceProtocol, ARelayThatDoesNotCloseIsAFault) {
  ASSERT_EQ(Arm(1000), kNone);
  device_.StickLines(1u << 17);  // R1 = 1 ohm does not let go
  ASSERT_EQ(Relay(kRelayNow, kOther), kNone);
  Pass(milliseconds(20));
  EXPECT_EQ(Status().fault, DeviceFault::kRelay);
  EXPECT_EQ(device_.abuse().two_connected, 0) << "nothing is added to a part that did not let go";
}

TEST_F(DeviceProtocol, AMissingValueIsAFault) {
  ASSERT_EQ(Plan(), kNone);
  ASSERT_EQ(Data(0, 20), kNone);
  ASSERT_EQ(Arm(1000), kNone);
  ASSERT_EQ(Ask(DeviceMessage::kStart), kNone);
  Pass(milliseconds(260));
  EXPECT_EQ(Status().fault, DeviceFault::kUnderrun);
  EXPECT_TRUE(device_.IsSafe());
}

TEST_F(DeviceProtocol, EndsInSafeWithThePlan) {
  ASSERT_EQ(Plan(20), kNone);
  ASSERT_EQ(Data(0, 20), kNone);
  ASSERT_EQ(Arm(1000), kNone);
  ASSERT_EQ(Ask(DeviceMessage::kStart), kNone);
  Pass(milliseconds(260));
  EXPECT_EQ(Status().state, DeviceState::kSafe);
  EXPECT_EQ(Status().next, 20u);
  EXPECT_EQ(port_.TakeSamples().size(), 20u);
  EXPECT_EQ(Ask(DeviceMessage::kResend, ResendPayload(19)), kNone);
  EXPECT_EQ(port_.TakeSamples().size(), 1u);
  EXPECT_EQ(Ask(DeviceMessage::kResend, ResendPayload(20)), kRange);
  EXPECT_EQ(Ask(DeviceMessage::kResend, ResendPayload(2)), kRange) << "no longer kept";
}

TEST_F(DeviceProtocol, KeepsTimeUpToFiveHundredHertz) {
  for (const std::uint32_t period_us : {10'000u, 4'000u, 2'000u}) {
    ASSERT_EQ(Ask(DeviceMessage::kPlan, PlanPayload(1000, period_us, period_us / 2)), kNone);
    std::uint32_t sent = 0;
    const auto fill = [&](std::uint32_t done) {
      while (sent < 1000 && sent + 20 <= done + info_.plan_values) {
        ASSERT_EQ(Data(sent, 20), kNone);
        sent += 20;
      }
    };
    fill(0);
    ASSERT_EQ(Arm(), kNone);
    device_.load();
    ASSERT_EQ(Ask(DeviceMessage::kStart), kNone);
    std::uint32_t done = 0;
    while (Status().state == DeviceState::kRun) {
      for (const DeviceSample& sample : port_.TakeSamples()) ASSERT_EQ(sample.k, done++);
      fill(done);
      Pass(milliseconds(10));
    }
    for (const DeviceSample& sample : port_.TakeSamples()) ASSERT_EQ(sample.k, done++);
    EXPECT_EQ(done, 1000u);
    EXPECT_EQ(Status().drops, 0);
    std::printf("%u us: processor busy %.0f %%\n", period_us, 100.0 * device_.load());
  }
  EXPECT_EQ(device_.uart_overruns(), 0u);
}

/// The encoder interrupts without end: the main loop crawls on, but no other interrupt comes, so
/// that no time passes for it. The chip's own watchdog must see that.
TEST_F(DeviceProtocol, AProgramThatHangsIsResetAndSafe) {
  ASSERT_EQ(Plan(), kNone);
  for (std::uint32_t first = 0; first < 120; first += 24) ASSERT_EQ(Data(first, 24), kNone);
  ASSERT_EQ(Arm(5000), kNone);
  ASSERT_EQ(Ask(DeviceMessage::kStart), kNone);
  Pass(milliseconds(100));
  EXPECT_GT(device_.drive_v(), 1.0);
  const Nanoseconds from = device_.now();
  device_.FloodEncoder(true);
  Pass(milliseconds(200));
  device_.FloodEncoder(false);
  const double zero_ms =
      std::chrono::duration<double, std::milli>(device_.drive_zero_at() - from).count();
  std::printf("program hangs: drive 0 after %.0f ms\n", zero_ms);
  EXPECT_GT(zero_ms, 50.0);
  EXPECT_LT(zero_ms, 160.0);
  Pass(milliseconds(50));
  EXPECT_TRUE(device_.IsSafe());
  port_.Poll();
  const auto restart = port_.TakeRestart();
  ASSERT_TRUE(restart.has_value());
  EXPECT_EQ(ResetCauseText(restart->reset_cause), "its own watchdog");
}

}  // namespace
}  // namespace faultlab::hardware
