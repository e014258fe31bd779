#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <future>

#include "faultlab_msgs/rig_bench_t.hpp"
#include "hardware/bench/bench_reader.h"
#include "hardware/bench/benches.h"
#include "hardware/lcm/rig_codec.h"
#include "hardware/lcm/sealed_message.h"
#include "tests/hardware/control_orders.h"
#include "tests/hardware/lcm_datagrams.h"
#include "tests/hardware/remote_world.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/wire_message.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

constexpr Epoch kEpoch{3};
constexpr double kSpeed = 10.0;
constexpr Weather kFine{};
constexpr Weather kStorm{.loss = 0.2, .duplicate = 0.1, .reorder = 0.1};

void Begin(Rig& rig, const RunPlan& plan) {
  const core::Status armed = rig.Arm(plan, kEpoch);
  ASSERT_TRUE(armed.ok()) << armed.error().message;
  ASSERT_TRUE(rig.Start(kEpoch).ok());
}

std::vector<core::Sample> Alone(const RunPlan& plan) {
  SimulatedRigOptions options;
  options.speed = 0.0;
  const auto rig = MakeSimulatedRig(options);
  Begin(*rig, plan);
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
  FarWorld far(kFine, 1, kSpeed);
  EXPECT_EQ(far.rig().state(), RigState::kIdle);
  EXPECT_EQ(far.rig().description().kind, RigKind::kRemote);
  EXPECT_TRUE(far.rig().description().any_value);
  RunPlan plan = SquarePlan(500);
  plan.faults = {{.component = paper::kR1, .value = 100.0, .at_s = 2.0}};
  const core::Status armed = far.rig().Arm(plan, kEpoch);
  ASSERT_TRUE(armed.ok()) << armed.error().message;
  EXPECT_EQ(far.rig().state(), RigState::kArmed);
  ASSERT_TRUE(far.rig().Start(kEpoch).ok());
  const RunLog log = Drain(far.rig());
  ExpectWhole(log, plan);
  EXPECT_EQ(log.events.front().kind, RigEventKind::kStarted);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
  ASSERT_EQ(log.Of(RigEventKind::kRelayConfirmed).size(), 1u);
  EXPECT_EQ(log.Of(RigEventKind::kRelayConfirmed)[0].index, 200);
  EXPECT_EQ(far.rig().state(), RigState::kIdle);
}

TEST(RemoteRig, KeepsItsSpeedByOrdersFromHere) {
  FarWorld far(kStorm, 12, 1.0);
  EXPECT_TRUE(far.rig().description().controls_speed);
  RunPlan plan = ControlledPlan();
  plan.uc_v.resize(60'000, 2.0);  // it is stopped when all is told
  plan.control->reference.high_rad_s = plan.control->reference.low_rad_s;
  Begin(far.rig(), plan);
  core::ControlOrder with_fault = Order();
  with_fault.alarmed = with_fault.named = true;
  with_fault.believed = core::BelievedFault{paper::kR1, 56.0, with_fault.healthy};
  // One after the other, each 100 samples after the one before was taken: the speed has settled.
  const std::vector<std::function<void()>> steps = {
      [&] { EXPECT_TRUE(far.rig().Command(kEpoch, Ordered(Order())).ok()); },
      [&] { EXPECT_TRUE(far.rig().Command(kEpoch, Ordered(with_fault)).ok()); },
      [&] { far.rig().SafeStop("enough"); }};
  std::atomic<std::size_t> done{0};
  std::vector<std::future<void>> asked;
  std::int64_t next_at = 120;
  const RunLog log = Drain(far.rig(), [&](const core::Sample& sample) {
    if (done < asked.size() || asked.size() == steps.size()) {
      next_at = sample.index + 100;
    } else if (sample.index >= next_at) {
      asked.push_back(std::async(std::launch::async, [&, step = steps[asked.size()]] {
        step();
        ++done;
      }));
    }
  });
  EXPECT_EQ(log.events.back().kind, RigEventKind::kStopped);
  const auto began = log.Of(RigEventKind::kControlBegan);
  ASSERT_EQ(began.size(), 1U);
  EXPECT_GT(began[0].index, 120);
  const auto made_up = log.Of(RigEventKind::kCompensated);
  ASSERT_EQ(made_up.size(), 1U);
  EXPECT_EQ(made_up[0].component, paper::kR1);
  EXPECT_EQ(made_up[0].value, 56.0);

  core::ControlOrder impossible = Order();
  impossible.healthy.gain = 0.0;
  Begin(far.rig(), plan);
  EXPECT_FALSE(far.rig().Command(kEpoch, Ordered(impossible)).ok());
  far.rig().SafeStop("enough");
}

TEST(RemoteRig, IsIdleOnceItIsStoppedAlthoughItsAgentAnnouncedThatItIsArmed) {
  FarWorld far(kFine, 11, kSpeed);
  ASSERT_TRUE(far.rig().Arm(SquarePlan(10), kEpoch).ok());
  const int before = far.server.announcements_heard;
  while (far.server.announcements_heard < before + 2) std::this_thread::yield();
  far.server.is_deaf_to_announcements = true;
  far.rig().SafeStop("enough");
  EXPECT_EQ(far.rig().state(), RigState::kIdle);
}

TEST(RemoteRig, LosesNothingInAStorm) {
  FarWorld far(kStorm, 2, kSpeed);
  const RunPlan plan = SquarePlan(1500);
  Begin(far.rig(), plan);
  ExpectWhole(Drain(far.rig()), plan);
  // How many samples share a message depends on the machine; how many messages are lost does not.
  EXPECT_GT(far.bus.lost() * 10, far.bus.overheard().size()) << "this was no storm";
  EXPECT_GT(far.rig().info().gaps_refilled, 0);
}

/// Seconds of a cut.
class ACut : public testing::TestWithParam<int> {};

TEST_P(ACut, LosesNothingWhenTheRunRidesThrough) {
  const std::chrono::seconds cut(GetParam());
  FarWorld far(kFine, 3, kSpeed, RidesThrough(90));
  const RunPlan plan = SquarePlan(500 + 100 * GetParam());
  Begin(far.rig(), plan);
  std::thread mender;
  const RunLog log = Drain(far.rig(), [&](const core::Sample& sample) {
    if (sample.index != 200) return;
    far.bus.SetCut(true);
    mender = std::thread([&far, cut] {
      const auto time = FastTime(kSpeed);  // seconds of the run
      const Nanoseconds until = time() + cut;
      while (time() < until) std::this_thread::yield();
      far.bus.SetCut(false);
    });
  });
  mender.join();
  ExpectWhole(log, plan);
  EXPECT_GT(far.rig().info().gaps_refilled, 60 * GetParam());
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
}

INSTANTIATE_TEST_SUITE_P(Seconds, ACut, testing::Values(1, 5, 60));

TEST(RemoteRig, SilenceOfTheServerStopsTheRunAndTheRecordingIsWholeUpToThere) {
  FarWorld far(kFine, 4, 1.0, RigAgentSettings{});
  Begin(far.rig(), SquarePlan(2000));
  std::thread mender;
  constexpr std::size_t kSeen = 21;  // by the server before the cut
  const RunLog log = Drain(far.rig(), [&](const core::Sample& sample) {
    if (sample.index + 1 != static_cast<std::int64_t>(kSeen)) return;
    far.bus.SetCut(true);
    mender = std::thread([&] {
      while (far.agent.rig().state() == RigState::kRunning) std::this_thread::yield();
      far.bus.SetCut(false);
    });
  });
  mender.join();
  EXPECT_THAT(log.last_text(), testing::HasSubstr("watchdog"));
  EXPECT_GT(log.samples.size(), kSeen) << "how many more is up to the machine";
  EXPECT_LT(log.samples.size(), 2000u);
  for (std::size_t k = 0; k < log.samples.size(); ++k) {
    ASSERT_EQ(log.samples[k].index, static_cast<std::int64_t>(k));
  }
  EXPECT_EQ(far.agent.rig().state(), RigState::kIdle);
}

TEST(RemoteRig, OnlyTheLeaseHolderCommands) {
  LossyBus bus(kFine, 5);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread first(bus, kSpeed, "one/first");
  ServerThread second(bus, kSpeed, "two/second");
  first.WaitUntilHeard();
  second.WaitUntilHeard();
  EXPECT_FALSE(second.rig().info().refusal);
  ASSERT_TRUE(first.rig().Arm(SquarePlan(500), kEpoch).ok());
  const core::Status refused = second.rig().Arm(SquarePlan(10), Epoch{100});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, core::ErrorCode::kBusy);
  EXPECT_EQ(refused.error().field, kLeaseField);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("one/first"));
  while (!second.rig().info().refusal) std::this_thread::yield();
  EXPECT_EQ(second.rig().info().refusal, RigRefusal::kHeldElsewhere);
  EXPECT_THAT(second.rig().info().refusal_text,
              testing::StartsWith("the rig is held by one/first"));
  EXPECT_FALSE(first.rig().info().refusal);
  ASSERT_TRUE(first.rig().Start(kEpoch).ok());
  EXPECT_FALSE(second.rig().Command(Epoch{100}, {}).ok());
  second.rig().SafeStop("not mine");
  EXPECT_EQ(Drain(first.rig()).samples.size(), 500u);
}

TEST(RemoteRig, IsOursBetweenRunsAndNobodyElsesWhileWeLive) {
  LossyBus bus(kFine, 15);
  const RigAgentSettings settings = RidesThrough(5);
  AgentThread agent(bus, kSpeed, settings);
  ServerThread first(bus, kSpeed, "one/first");
  ServerThread second(bus, kSpeed, "two/second");
  first.WaitUntilHeard();
  second.WaitUntilHeard();
  Begin(first.rig(), SquarePlan(5));
  (void)Drain(first.rig());
  const auto time = FastTime(kSpeed);
  const Nanoseconds until = time() + 5 * settings.lease / 2;
  while (time() < until) {
    EXPECT_EQ(second.rig().Arm(SquarePlan(5), Epoch{100}).error().code, core::ErrorCode::kBusy);
  }
}

TEST(RemoteRig, AHigherEpochOfItsOwnLabTakesItOverAtOnce) {
  LossyBus bus(kFine, 16);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread frozen(bus, kSpeed, "lab/frozen");
  ServerThread next(bus, kSpeed, "lab/next");
  frozen.WaitUntilHeard();
  next.WaitUntilHeard();
  Begin(frozen.rig(), SquarePlan(6000));
  const core::Status armed = next.rig().Arm(SquarePlan(50), Epoch{4});
  ASSERT_TRUE(armed.ok()) << armed.error().message;
  EXPECT_EQ(Drain(frozen.rig()).last_text(), "the lease was revoked");
  // Whatever it sends, it gets no answer.
  EXPECT_EQ(frozen.rig().Arm(SquarePlan(10), kEpoch).error().code, core::ErrorCode::kStale);
  EXPECT_EQ(frozen.rig().Arm(SquarePlan(10), Epoch{4}).error().code, core::ErrorCode::kUnavailable);
  ASSERT_TRUE(next.rig().Start(Epoch{4}).ok());
  EXPECT_EQ(Drain(next.rig()).samples.size(), 50u);
}

TEST(RemoteRig, AnEpochBelowTheRigsIsRefusedAsStaleAndNamesBoth) {
  LossyBus bus(kFine, 17);
  AgentThread agent(bus, kSpeed, RidesThrough(60));
  ServerThread server(bus, kSpeed, "lab/a");
  ServerThread behind(bus, kSpeed, "lab/b");
  server.WaitUntilHeard();
  behind.WaitUntilHeard();
  ASSERT_TRUE(server.rig().Arm(SquarePlan(10), Epoch{500}).ok());
  const core::Result<SelfTestReport> refused = behind.rig().SelfTest(Epoch{3});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, core::ErrorCode::kStale);
  EXPECT_EQ(refused.error().field, kLeaseField);
  EXPECT_EQ(refused.error().message,
            "the rig has seen epoch 500 of lab/a, this lease is of epoch 3");
  while (behind.rig().info().epoch != Epoch{500}) std::this_thread::yield();
}

/// The commands that were published after the first `from` messages, received or not.
std::vector<faultlab_msgs::rig_command_t> CommandsFrom(const LossyBus& bus, std::size_t from) {
  std::vector<faultlab_msgs::rig_command_t> commands;
  const auto overheard = bus.overheard();
  for (std::size_t i = from; i < overheard.size(); ++i) {
    if (overheard[i].first != CommandChannel("far-1")) continue;
    commands.push_back(Opened<faultlab_msgs::rig_command_t>(
                           overheard[i].second, overheard[i].first, "far-1", TestKey())
                           .value());
  }
  return commands;
}

/// The link is dead: Fence returns at once, nothing of the old epoch is accepted any more, and the
/// agent is informed as soon as the link is back.
TEST(RemoteRig, AFenceWaitsForNoNetworkAndReachesTheAgentWhenThereIsOne) {
  LossyBus bus(kFine, 18);
  AgentThread agent(bus, kSpeed, RidesThrough(600));
  ServerThread server(bus, kSpeed, "lab/a", /*give_up=*/std::chrono::hours(10));
  server.WaitUntilHeard();
  Begin(server.rig(), SquarePlan(50'000));
  std::future<RunLog> reader = std::async(std::launch::async, [&] { return Drain(server.rig()); });
  const std::size_t begun = bus.overheard().size();
  std::future<core::Status> caught;
  const auto ask = [&] {
    server.WaitUntilHeard();
    bus.SetCut(true);
    caught = std::async(std::launch::async, [&] {
      return server.rig().Command(kEpoch, {});  // waits for an answer that never comes
    });
  };
  const auto asks = [&] {
    const auto commands = CommandsFrom(bus, begun);
    return std::any_of(commands.begin(), commands.end(), [](const auto& command) {
      return command.action == "nominal";
    });
  };
  ask();
  while (!asks()) {
    if (caught.wait_for(std::chrono::milliseconds(1)) == std::future_status::timeout) continue;
    bus.SetCut(false);  // a busy machine found the link lost before it asked
    ask();
  }
  std::future<void> fenced = std::async(std::launch::async, [&] { server.rig().Fence(Epoch{4}); });
  const bool at_once = fenced.wait_for(std::chrono::seconds(5)) == std::future_status::ready;
  EXPECT_TRUE(at_once) << "Fence waits for the network";
  const std::size_t before = bus.overheard().size();
  if (at_once) {
    EXPECT_EQ(server.rig().Command(kEpoch, {}).error().code, core::ErrorCode::kStale);
    EXPECT_EQ(server.rig().Start(kEpoch).error().code, core::ErrorCode::kStale);
    EXPECT_EQ(server.rig().Arm(SquarePlan(10), kEpoch).error().code, core::ErrorCode::kStale);
    EXPECT_EQ(server.rig().SelfTest(kEpoch).error().code, core::ErrorCode::kStale);
    EXPECT_EQ(caught.wait_for(std::chrono::seconds(5)), std::future_status::ready);
    EXPECT_EQ(agent.rig().state(), RigState::kRunning) << "it cannot know";
  }
  bus.SetCut(false);
  EXPECT_EQ(caught.get().error().code, core::ErrorCode::kStale) << "who waits is told";
  EXPECT_EQ(reader.get().last_text(), "the lease was revoked");
  EXPECT_EQ(agent.rig().state(), RigState::kIdle);
  for (const faultlab_msgs::rig_command_t& command : CommandsFrom(bus, before)) {
    EXPECT_EQ(command.epoch, 4) << command.action << " leaves after the fence";
  }
  ServerThread frozen(bus, kSpeed, "lab/frozen");
  frozen.WaitUntilHeard();
  EXPECT_EQ(frozen.rig().Arm(SquarePlan(10), kEpoch).error().code, core::ErrorCode::kStale)
      << "the agent refuses the old epoch, too";
  EXPECT_TRUE(server.rig().Arm(SquarePlan(10), Epoch{4}).ok());
}

TEST(RemoteRig, AFenceIsHeardInAStorm) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    LossyBus bus({.loss = 0.4, .duplicate = 0.1, .reorder = 0.1}, seed);
    AgentThread agent(bus, kSpeed, RidesThrough(60));
    ServerThread server(bus, kSpeed, "lab/a");
    server.WaitUntilHeard();
    Begin(server.rig(), SquarePlan(3000));
    server.rig().Fence(Epoch{4});
    server.rig().Fence(Epoch{5});
    EXPECT_EQ(Drain(server.rig()).last_text(), "the lease was revoked") << seed;
    ASSERT_TRUE(server.rig().Arm(SquarePlan(20), Epoch{5}).ok()) << seed;
    ASSERT_TRUE(server.rig().Start(Epoch{5}).ok()) << seed;
    EXPECT_EQ(Drain(server.rig()).samples.size(), 20u) << seed;
  }
}

TEST(RemoteRig, AKilledServerLeavesASafeRigThatTheNextServerMayTake) {
  LossyBus bus(kFine, 7);
  AgentThread agent(bus, kSpeed, RigAgentSettings{});
  {
    ServerThread killed(bus, kSpeed, "killed");
    killed.WaitUntilHeard();
    Begin(killed.rig(), SquarePlan(6000));
    bus.SetCut(true);
  }
  while (agent.rig().state() == RigState::kRunning) std::this_thread::yield();
  bus.SetCut(false);
  ServerThread next(bus, kSpeed, "next");
  next.WaitUntilHeard();
  core::Status armed = next.rig().Arm(SquarePlan(50), Epoch{4});
  while (!armed.ok() && armed.error().code == core::ErrorCode::kBusy) {
    armed = next.rig().Arm(SquarePlan(50), Epoch{4});  // until the dead server's lease has ended
  }
  ASSERT_TRUE(armed.ok()) << armed.error().message;
  ASSERT_TRUE(next.rig().Start(Epoch{4}).ok());
  EXPECT_EQ(Drain(next.rig()).samples.size(), 50u);
}

TEST(RemoteRig, AKilledAgentIsLostThenBackAndTheRunSaysSo) {
  LossyBus bus(kFine, 8);
  const StateFolder state;
  auto agent = std::make_unique<AgentThread>(bus, kSpeed, RidesThrough(60), "far-1", &state);
  ServerThread server(bus, kSpeed, "a");
  server.WaitUntilHeard();
  Begin(server.rig(), SquarePlan(6000));
  std::future<RunLog> reader = std::async(std::launch::async, [&] { return Drain(server.rig()); });
  bus.SetCut(true);  // its last message must not arrive
  agent.reset();
  while (server.rig().info().link != LinkState::kLost) std::this_thread::yield();
  bus.SetCut(false);
  agent = std::make_unique<AgentThread>(bus, kSpeed, RidesThrough(60), "far-1", &state);
  const RunLog log = reader.get();
  EXPECT_EQ(log.last_text(), "the agent started anew");
  EXPECT_EQ(server.rig().info().link, LinkState::kBack);
  ServerThread frozen(bus, kSpeed, "a/frozen");
  frozen.WaitUntilHeard();
  EXPECT_EQ(frozen.rig().Arm(SquarePlan(10), Epoch{2}).error().code, core::ErrorCode::kStale);
  EXPECT_TRUE(server.rig().Arm(SquarePlan(10), kEpoch).ok()) << "the lease goes on";
}

TEST(RemoteRig, MeasuresTheAgentsClock) {
  FarWorld far(kFine, 9, kSpeed);
  ASSERT_TRUE(far.rig().Arm(SquarePlan(10), kEpoch).ok());
  const RemoteRigInfo info = far.rig().info();
  ASSERT_TRUE(info.clock_offset_s.has_value());
  EXPECT_LE(std::abs(*info.clock_offset_s), info.round_trip_s + 1e-6);  // it is the same clock
  EXPECT_TRUE(info.held_by_us);
  EXPECT_EQ(info.holder.empty() || info.holder == "lab/a", true);
}

TEST(RemoteRig, WalksItsSixteenRelayPositions) {
  FarWorld far(kFine, 10, kSpeed);
  const SelfTestReport report = far.rig().SelfTest(kEpoch).value();
  EXPECT_TRUE(report.ok);
  ASSERT_EQ(report.positions.size(), 16u);
  EXPECT_EQ(report.positions[0].line, "Do17");
  EXPECT_EQ(report.positions[3].value, 100.0);
}

TEST(RemoteRig, WhoseAgentSpeaksAnotherProtocolIsRefusedInWords) {
  LossyBus bus(kFine, 12);
  const std::shared_ptr<MessageBus> end = bus.MakeEnd();
  // Of a later version, and of the version before messages were sealed: its mac is at the end of
  // any layout.
  const auto later = [](const RigKey& key) {
    return SealBytes(SomeBytes(300), kAnnounceChannel, "far-1", key, kProtocol + 1);
  };
  std::vector<std::uint8_t> older = SomeBytes(300);
  const Mac mac = ComputeMac(TestKey(), older);
  older.insert(older.end(), mac.begin(), mac.end());
  for (const auto& bytes : {later(TestKey()), older}) {
    RemoteRig rig("far-1", end, {.holder = "lab/a", .key = TestKey()}, FastTime(kSpeed), UnixNs);
    EXPECT_FALSE(rig.info().refusal);
    EXPECT_TRUE(rig.OnAnnounce(bytes));
    EXPECT_EQ(rig.state(), RigState::kOffline);
    EXPECT_EQ(rig.info().refusal, RigRefusal::kOtherProtocol);
    EXPECT_THAT(rig.info().refusal_text, testing::HasSubstr("versions that do not understand"));
    EXPECT_FALSE(rig.Arm(SquarePlan(10), kEpoch).ok());
  }
  RigKey wrong = TestKey();
  wrong[0] ^= 1;
  RemoteRig other("far-1", end, {.holder = "lab/a", .key = TestKey()}, FastTime(kSpeed), UnixNs);
  EXPECT_FALSE(other.OnAnnounce(later(wrong)));
  EXPECT_EQ(other.info().refusal, RigRefusal::kOtherKey) << "which protocol, anybody may say";
}

std::vector<std::uint8_t> Announcement(const core::Bench& bench, std::int64_t seq) {
  faultlab_msgs::rig_announce_t said{};
  RigDescription description;
  description.bench = &bench;
  Encode(description, said);
  said.rig = "far-1";
  said.boot = 1;
  said.seq = seq;
  return Sealed(said, kAnnounceChannel, TestKey());
}

std::vector<std::uint8_t> Description(const std::string& text) {
  faultlab_msgs::rig_bench_t said;
  said.rig = "far-1";
  said.text = text;
  return Sealed(said, BenchChannel("far-1"), TestKey());
}

TEST(RemoteRig, IsWhatItsAgentDescribesAndNothingBefore) {
  LossyBus bus(kFine, 13);
  const std::shared_ptr<MessageBus> end = bus.MakeEnd();
  // Read, not kept: nobody in this process knows the bench by its id.
  std::string text = paper::Bench().text;
  text.replace(text.find("J = 1.43e-6"), 11, "J = 1.44e-6");
  const core::Bench mine = ReadBench(text, "").value();
  ASSERT_EQ(FindKeptBench(mine.id), nullptr);
  RemoteRig rig("far-1", end, {.holder = "lab/a", .key = TestKey()}, FastTime(kSpeed), UnixNs);
  rig.OnAnnounce(Announcement(mine, 1));
  EXPECT_FALSE(rig.IsDescribed());
  rig.OnBench(Description("[bench]\nname = 1\n"));
  EXPECT_THAT(rig.bench_refusal(), testing::HasSubstr("bench of far-1:2: bench.name"));
  EXPECT_FALSE(rig.IsDescribed());
  rig.OnBench(Description(mine.text));
  EXPECT_EQ(rig.bench_refusal(), "");
  ASSERT_TRUE(rig.IsDescribed());
  EXPECT_EQ(rig.description().bench->id, mine.id);
  EXPECT_FALSE(rig.AnnouncesAnotherBench());
  rig.OnAnnounce(Announcement(paper::Bench(), 2));
  EXPECT_TRUE(rig.AnnouncesAnotherBench());
  EXPECT_EQ(rig.description().bench->id, mine.id) << "readers hold a reference";
}

TEST(RigAgent, SendsTheDescriptionOfItsBenchBesideItsAnnouncements) {
  LossyBus bus(kFine, 14);
  const auto end = bus.MakeEnd();
  std::optional<std::string> text;
  end->Subscribe(
      "FAULTLAB\\.far-1\\.BENCH", [&](const std::string& channel, MessageBus::Bytes bytes) {
        const auto said = Opened<faultlab_msgs::rig_bench_t>(bytes, channel, "far-1", TestKey());
        if (said) text = said->text;
      });
  AgentThread agent(bus, kSpeed, RigAgentSettings{});
  while (!text) end->Handle(std::chrono::milliseconds(1));
  EXPECT_EQ(*text, paper::Bench().text);
}

}  // namespace
}  // namespace faultlab::hardware
