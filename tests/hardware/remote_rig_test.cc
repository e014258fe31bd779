#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>

#include "tests/hardware/remote_world.h"
#include "tests/hardware/rig_runs.h"

namespace faultlab::hardware {
namespace {

constexpr Epoch kEpoch{3};
constexpr double kSpeed = 10.0;
constexpr Weather kFine{};
constexpr Weather kStorm{.loss = 0.2, .duplicate = 0.1, .reorder = 0.1};

RigAgentSettings RidesThrough(int seconds) {
  RigAgentSettings settings;
  settings.watchdog = std::chrono::seconds(seconds);
  settings.lease = std::chrono::seconds(seconds + 5);
  return settings;
}

std::vector<core::Sample> Alone(const RunPlan& plan) {
  SimulatedRigOptions options;
  options.speed = 0.0;
  const auto rig = MakeSimulatedRig(options);
  EXPECT_TRUE(rig->Arm(plan, kEpoch).ok());
  EXPECT_TRUE(rig->Start(kEpoch).ok());
  return Drain(*rig).samples;
}

void ExpectWhole(const RunLog& log, const RunPlan& plan) {
  const std::vector<core::Sample> expected = Alone(plan);
  ASSERT_EQ(log.samples.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    ASSERT_EQ(log.samples[k].index, expected[k].index);
    ASSERT_EQ(log.samples[k].um_v, expected[k].um_v) << k;
    ASSERT_EQ(log.samples[k].n_rpm, expected[k].n_rpm) << k;
  }
  EXPECT_TRUE(log.Of(RigEventKind::kGap).empty());
}

TEST(RemoteRig, RunsAsIfItWereHere) {
  LossyBus bus(kFine, 1);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread server(bus, kSpeed, "a");
  server.WaitUntilHeard();
  EXPECT_EQ(server.rig().state(), RigState::kIdle);
  EXPECT_EQ(server.rig().description().kind, RigKind::kRemote);
  EXPECT_TRUE(server.rig().description().any_value);
  RunPlan plan = SquarePlan(500);
  plan.faults = {{.component = core::Component::kR1, .value = 100.0, .at_s = 2.0}};
  const core::Status armed = server.rig().Arm(plan, kEpoch);
  ASSERT_TRUE(armed.ok()) << armed.error().message;
  EXPECT_EQ(server.rig().state(), RigState::kArmed);
  ASSERT_TRUE(server.rig().Start(kEpoch).ok());
  const RunLog log = Drain(server.rig());
  ExpectWhole(log, plan);
  EXPECT_EQ(log.events.front().kind, RigEventKind::kStarted);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
  ASSERT_EQ(log.Of(RigEventKind::kRelayConfirmed).size(), 1u);
  EXPECT_EQ(log.Of(RigEventKind::kRelayConfirmed)[0].index, 200);
  EXPECT_EQ(server.rig().state(), RigState::kIdle);
}

TEST(RemoteRig, LosesNothingInAStorm) {
  LossyBus bus(kStorm, 2);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread server(bus, kSpeed, "a");
  server.WaitUntilHeard();
  const RunPlan plan = SquarePlan(1500);
  ASSERT_TRUE(server.rig().Arm(plan, kEpoch).ok());
  ASSERT_TRUE(server.rig().Start(kEpoch).ok());
  ExpectWhole(Drain(server.rig()), plan);
  // How many samples share a message is the machine's mood; how many messages are lost is not.
  EXPECT_GT(bus.lost() * 10, bus.overheard().size()) << "this was no storm";
  EXPECT_GT(server.rig().info().gaps_refilled, 0);
}

TEST(RemoteRig, ACutOfFiveSecondsLosesNothingWhenTheRunRidesThrough) {
  LossyBus bus(kFine, 3);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread server(bus, kSpeed, "a");
  server.WaitUntilHeard();
  const RunPlan plan = SquarePlan(1000);
  ASSERT_TRUE(server.rig().Arm(plan, kEpoch).ok());
  ASSERT_TRUE(server.rig().Start(kEpoch).ok());
  std::thread mender;
  const RunLog log = Drain(server.rig(), [&](const core::Sample& sample) {
    if (sample.index != 200) return;
    bus.SetCut(true);
    mender = std::thread([&] {
      // 5 s of the run.
      const auto time = FastTime(kSpeed);
      const Nanoseconds until = time() + std::chrono::seconds(5);
      while (time() < until) std::this_thread::yield();
      bus.SetCut(false);
    });
  });
  mender.join();
  ExpectWhole(log, plan);
  EXPECT_GT(server.rig().info().gaps_refilled, 300);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
}

TEST(RemoteRig, SilenceOfTheServerStopsTheRunAndTheRecordingIsWholeUpToThere) {
  LossyBus bus(kFine, 4);
  AgentThread agent(bus, 1.0, RigAgentSettings{});
  ServerThread server(bus, 1.0, "a");
  server.WaitUntilHeard();
  ASSERT_TRUE(server.rig().Arm(SquarePlan(2000), kEpoch).ok());
  ASSERT_TRUE(server.rig().Start(kEpoch).ok());
  std::thread mender;
  const RunLog log = Drain(server.rig(), [&](const core::Sample& sample) {
    if (sample.index != 20) return;
    bus.SetCut(true);
    mender = std::thread([&] {
      while (agent.rig().state() == RigState::kRunning) std::this_thread::yield();
      bus.SetCut(false);
    });
  });
  mender.join();
  EXPECT_THAT(log.last_text(), testing::HasSubstr("watchdog"));
  EXPECT_GT(log.samples.size(), 60u);
  EXPECT_LT(log.samples.size(), 2000u);
  for (std::size_t k = 0; k < log.samples.size(); ++k) {
    ASSERT_EQ(log.samples[k].index, static_cast<std::int64_t>(k));
  }
  EXPECT_EQ(agent.rig().state(), RigState::kIdle);
}

TEST(RemoteRig, OnlyTheLeaseHolderCommands) {
  LossyBus bus(kFine, 5);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread first(bus, kSpeed, "first");
  ServerThread second(bus, kSpeed, "second");
  first.WaitUntilHeard();
  second.WaitUntilHeard();
  ASSERT_TRUE(first.rig().Arm(SquarePlan(500), kEpoch).ok());
  const core::Status refused = second.rig().Arm(SquarePlan(10), kEpoch);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, core::ErrorCode::kBusy);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("first"));
  ASSERT_TRUE(first.rig().Start(kEpoch).ok());
  EXPECT_FALSE(second.rig().Command(kEpoch, {}).ok());
  second.rig().SafeStop("not mine");
  EXPECT_EQ(Drain(first.rig()).samples.size(), 500u);
}

TEST(RemoteRig, ANewLocalEpochFencesTheOldOneAtTheAgentToo) {
  LossyBus bus(kFine, 6);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread server(bus, kSpeed, "a");
  server.WaitUntilHeard();
  ASSERT_TRUE(server.rig().Arm(SquarePlan(2000), kEpoch).ok());
  ASSERT_TRUE(server.rig().Start(kEpoch).ok());
  server.rig().Fence(Epoch{4});
  EXPECT_EQ(Drain(server.rig()).last_text(), "the lease was revoked");
  EXPECT_EQ(server.rig().Arm(SquarePlan(10), kEpoch).error().code, core::ErrorCode::kStale);
  EXPECT_TRUE(server.rig().Arm(SquarePlan(10), Epoch{4}).ok());
}

TEST(RemoteRig, AKilledServerLeavesASafeRigThatTheNextServerMayTake) {
  LossyBus bus(kFine, 7);
  AgentThread agent(bus, kSpeed, RigAgentSettings{});
  {
    ServerThread killed(bus, kSpeed, "killed");
    killed.WaitUntilHeard();
    ASSERT_TRUE(killed.rig().Arm(SquarePlan(6000), kEpoch).ok());
    ASSERT_TRUE(killed.rig().Start(kEpoch).ok());
    bus.SetCut(true);
  }
  while (agent.rig().state() == RigState::kRunning) std::this_thread::yield();
  bus.SetCut(false);
  ServerThread next(bus, kSpeed, "next");
  next.WaitUntilHeard();
  core::Status armed = next.rig().Arm(SquarePlan(50), kEpoch);
  while (!armed.ok() && armed.error().code == core::ErrorCode::kBusy) {
    armed = next.rig().Arm(SquarePlan(50), kEpoch);  // until the dead server's lease ran out
  }
  ASSERT_TRUE(armed.ok()) << armed.error().message;
  ASSERT_TRUE(next.rig().Start(kEpoch).ok());
  EXPECT_EQ(Drain(next.rig()).samples.size(), 50u);
}

TEST(RemoteRig, AKilledAgentIsLostThenBackAndTheRunSaysSo) {
  LossyBus bus(kFine, 8);
  auto agent = std::make_unique<AgentThread>(bus, kSpeed, RidesThrough(60));
  ServerThread server(bus, kSpeed, "a");
  server.WaitUntilHeard();
  ASSERT_TRUE(server.rig().Arm(SquarePlan(6000), kEpoch).ok());
  ASSERT_TRUE(server.rig().Start(kEpoch).ok());
  std::future<RunLog> reader = std::async(std::launch::async, [&] { return Drain(server.rig()); });
  bus.SetCut(true);  // its goodbye must not be heard
  agent.reset();
  while (server.rig().info().link != LinkState::kLost) std::this_thread::yield();
  bus.SetCut(false);
  agent = std::make_unique<AgentThread>(bus, kSpeed, RidesThrough(60));
  const RunLog log = reader.get();
  EXPECT_EQ(log.last_text(), "the agent started anew");
  EXPECT_EQ(server.rig().info().link, LinkState::kBack);
  EXPECT_TRUE(server.rig().Arm(SquarePlan(10), kEpoch).ok());
}

TEST(RemoteRig, MeasuresTheAgentsClock) {
  LossyBus bus(kFine, 9);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread server(bus, kSpeed, "a");
  server.WaitUntilHeard();
  ASSERT_TRUE(server.rig().Arm(SquarePlan(10), kEpoch).ok());
  const RemoteRigInfo info = server.rig().info();
  ASSERT_TRUE(info.clock_offset_s.has_value());
  EXPECT_LE(std::abs(*info.clock_offset_s), info.round_trip_s + 1e-6);  // it is the same clock
  EXPECT_TRUE(info.held_by_us);
  EXPECT_EQ(info.holder.empty() || info.holder == "a", true);
}

TEST(RemoteRig, WalksItsSixteenRelayPositions) {
  LossyBus bus(kFine, 10);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread server(bus, kSpeed, "a");
  server.WaitUntilHeard();
  const SelfTestReport report = server.rig().SelfTest(kEpoch).value();
  EXPECT_TRUE(report.ok);
  ASSERT_EQ(report.positions.size(), 16u);
  EXPECT_EQ(report.positions[0].line, "Do17");
  EXPECT_EQ(report.positions[3].value, 100.0);
}

TEST(RemoteRig, WithoutTheKeyMayOnlyWatch) {
  LossyBus bus(kFine, 11);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  std::shared_ptr<MessageBus> end = bus.MakeEnd();
  RemoteRig watcher("far-1", end, {.holder = "w", .key = std::nullopt}, FastTime(kSpeed), UnixNs);
  end->Subscribe("FAULTLAB\\.ANNOUNCE",
                 [&](const std::string&, MessageBus::Bytes bytes) { watcher.OnAnnounce(bytes); });
  while (watcher.info().link != LinkState::kBack) end->Handle(std::chrono::milliseconds(10));
  EXPECT_EQ(watcher.state(), RigState::kIdle);
  EXPECT_FALSE(watcher.info().key_known);
  const core::Status refused = watcher.Arm(SquarePlan(10), kEpoch);
  EXPECT_EQ(refused.error().code, core::ErrorCode::kForbidden);
}

}  // namespace
}  // namespace faultlab::hardware
