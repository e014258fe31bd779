// Remote rigs over real UDP multicast.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "hardware/clock.h"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/lcm_log.h"
#include "hardware/lcm/lcm_tap.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/rig_agent_program.h"
#include "hardware/lcm/rig_finder.h"
#include "hardware/lcm/sealed_message.h"
#include "tests/hardware/lcm_datagrams.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/wire_message.h"
#include "tests/paper_bench.h"
#include "tests/support/await.h"
#include "tests/system/network/lcm_logger.h"
#include "tests/system/network/network_world.h"
#include "tests/system/network/udp_relay.h"

namespace faultlab::hardware {
namespace {

constexpr Epoch kEpoch{1};
constexpr int kServerPort = 7668;  // the other side of the relay

/// `faultlab rig` as a process.
pid_t ForkAgent(const std::string& id) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  RigAgentOptions options;
  options.id = id;
  options.lcm_url = Url(kAgentPort);
  options.key_directory = KeyFolder();
  options.state_directory = KeyFolder();
  options.supervise = false;
  _exit(RunRigAgent(options));
}

/// Sends an empty frame at the pace of a run, because lcm-logger's small socket buffer loses faster
/// frames.
void PublishPaced(LcmTap::Stream& stream) {
  const auto clock = MakeSteadyClock();
  (void)clock->SleepUntil(clock->Now() + std::chrono::milliseconds(5));
  stream.Publish(core::Frame{});
}

TEST(Network, AStormLosesNoSample) {
  AgentHere agent("net-1", 2.0, 30.0);
  UdpRelay relay(kAgentPort,
                 kServerPort,
                 {.loss = 0.15, .duplicate = 0.05, .reorder = 0.1, .delay_ms = 20},
                 1);
  const auto finder = Finder(kServerPort, "here");
  const auto rig = WaitFor(*finder, "net-1");
  const core::Status armed = rig->Arm(SquarePlan(600), kEpoch);
  ASSERT_TRUE(armed.ok()) << armed.error().message;
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  ExpectEveryIndex(Drain(*rig), 600);
  EXPECT_GT(relay.lost(), 50u);
}

TEST(Network, ACutOfFiveSecondsLosesNoSample) {
  AgentHere agent("net-2", 1.0, 30.0);
  UdpRelay relay(kAgentPort, kServerPort, {}, 2);
  const auto finder = Finder(kServerPort, "here");
  const auto rig = WaitFor(*finder, "net-2");
  ASSERT_TRUE(rig->Arm(SquarePlan(800), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  std::thread mender;
  std::vector<LinkState> seen;
  const RunLog log = Drain(*rig, [&](const core::Sample& sample) {
    if (sample.index != 100) return;
    relay.SetCut(true);
    mender = std::thread([&] {
      const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(5);
      while (std::chrono::steady_clock::now() < until) {
        const LinkState link = InfoOf(*finder, "net-2").link;
        if (seen.empty() || seen.back() != link) seen.push_back(link);
        std::this_thread::yield();
      }
      relay.SetCut(false);
    });
  });
  mender.join();
  ExpectEveryIndex(log, 800);
  EXPECT_EQ(log.events.back().kind, RigEventKind::kFinished);
  EXPECT_GT(InfoOf(*finder, "net-2").gaps_refilled, 300);
  EXPECT_EQ(seen, (std::vector{LinkState::kBack, LinkState::kLate, LinkState::kLost}));
}

TEST(Network, SixtySecondsOfARunThatWereNotHeardAreRefilled) {
  AgentHere agent("net-3", 20.0, 30.0);  // 60 s of the run pass in 3 s
  UdpRelay relay(kAgentPort, kServerPort, {}, 3);
  const auto finder = Finder(kServerPort, "here");
  const auto rig = WaitFor(*finder, "net-3");
  ASSERT_TRUE(rig->Arm(SquarePlan(8000), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  std::thread mender;
  const RunLog log = Drain(*rig, [&](const core::Sample& sample) {
    if (sample.index != 500) return;
    relay.SetCut(true);
    mender = std::thread([&] {
      const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(3);
      while (std::chrono::steady_clock::now() < until) std::this_thread::yield();
      relay.SetCut(false);
    });
  });
  mender.join();
  ExpectEveryIndex(log, 8000);
  EXPECT_GT(InfoOf(*finder, "net-3").gaps_refilled, 5000);
}

TEST(Network, AKilledAgentIsLostAndItsNextStartIsFound) {
  constexpr Epoch kSession{41};
  pid_t agent = ForkAgent("net-4");
  const auto finder = Finder(kAgentPort, "here", "lab");
  auto key = LoadRigKey(KeyFolder(), "net-4");
  while (!key.ok() || !key.value()) key = LoadRigKey(KeyFolder(), "net-4");
  const auto rig = WaitFor(*finder, "net-4");
  ASSERT_TRUE(rig->Arm(SquarePlan(5000), kSession).ok());
  ASSERT_TRUE(rig->Start(kSession).ok());
  std::vector<RigMessage> first;
  while (first.empty()) (void)rig->Read(first, std::chrono::milliseconds(100));
  kill(agent, SIGKILL);
  EXPECT_TRUE(WIFSIGNALED(StatusOf(agent)));
  std::thread reviver([&] {
    while (InfoOf(*finder, "net-4").link != LinkState::kLost) std::this_thread::yield();
    agent = ForkAgent("net-4");
  });
  EXPECT_EQ(Drain(*rig).last_text(), "the agent started anew");
  reviver.join();
  EXPECT_EQ(InfoOf(*finder, "net-4").link, LinkState::kBack);
  // The rig stores what it has seen: an older lease of the lab is refused, that of the session
  // continues.
  const auto other = Finder(kAgentPort, "other", "lab");
  const core::Status stale = WaitFor(*other, "net-4")->Arm(SquarePlan(20), Epoch{40});
  EXPECT_EQ(stale.error().code, core::ErrorCode::kStale) << stale.error().message;
  EXPECT_NE(stale.error().message.find("seen epoch 41 of lab/here"), std::string::npos)
      << stale.error().message;
  ASSERT_TRUE(rig->Arm(SquarePlan(20), kSession).ok());
  ASSERT_TRUE(rig->Start(kSession).ok());
  ExpectEveryIndex(Drain(*rig), 20);
  kill(agent, SIGTERM);
  const int status = StatusOf(agent);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "SIGTERM ends in a safe stop";
}

TEST(Network, AKilledServerStopsTheRunAndTheNextOneGetsTheRig) {
  // Fork while this process has one thread: a lock held by another thread would stay locked for
  // ever.
  const pid_t server = fork();
  if (server == 0) {
    const auto finder = Finder(kAgentPort, "doomed");
    const auto rig = WaitFor(*finder, "net-5");
    if (!rig->Arm(SquarePlan(50'000), kEpoch).ok() || !rig->Start(kEpoch).ok()) _exit(1);
    std::vector<RigMessage> some;
    while (some.size() < 50) (void)rig->Read(some, std::chrono::milliseconds(100));
    kill(getpid(), SIGKILL);
  }
  AgentHere agent("net-5", 1.0, 0.0);
  ASSERT_TRUE(WIFSIGNALED(StatusOf(server))) << "it could not start the run";
  const auto killed_at = std::chrono::steady_clock::now();
  ASSERT_TRUE(tests::Await([&] { return agent.rig().state() != RigState::kRunning; }));
  const std::chrono::duration<double> silence = std::chrono::steady_clock::now() - killed_at;
  std::printf("drive 0 %.0f ms after the server's death\n", silence.count() * 1e3);
  const auto finder = Finder(kAgentPort, "next");
  const auto rig = WaitFor(*finder, "net-5");
  EXPECT_EQ(InfoOf(*finder, "net-5").epoch, kEpoch);
  constexpr Epoch kNext{2};
  core::Status armed = rig->Arm(SquarePlan(20), kNext);
  while (!armed.ok() && armed.error().code == core::ErrorCode::kBusy) {
    armed = rig->Arm(SquarePlan(20), kNext);
  }
  ASSERT_TRUE(armed.ok()) << armed.error().message;
  ASSERT_TRUE(rig->Start(kNext).ok());
  ExpectEveryIndex(Drain(*rig), 20);
}

TEST(Network, AnImpostorChangesNothing) {
  AgentHere agent("net-6", 2.0, 30.0);
  const auto finder = Finder(kAgentPort, "here");
  const auto rig = WaitFor(*finder, "net-6");
  RunLog log;
  std::uint64_t sent = 0;
  {
    UdpImpostor impostor(kAgentPort, 6);
    const core::Status armed = rig->Arm(SquarePlan(600), kEpoch);
    ASSERT_TRUE(armed.ok()) << armed.error().message;
    ASSERT_TRUE(rig->Start(kEpoch).ok());
    log = Drain(*rig);
    sent = impostor.sent();
  }
  ExpectEveryIndex(log, 600);
  EXPECT_TRUE(log.Of(RigEventKind::kFaultCommanded).empty());
  const RigAgentCounts& counts = agent.Stop();
  std::printf("%lu datagrams of the impostor: %lu forged, %lu replayed, 0 accepted\n",
              static_cast<unsigned long>(sent),
              static_cast<unsigned long>(counts.forged),
              static_cast<unsigned long>(counts.replayed));
  EXPECT_GT(counts.replayed, 0u);
  EXPECT_GT(counts.forged, 0u);
}

/// Sends messages of a type on the bus, each with one length that no real message has.
template <typename Message>
int PublishBadLengths(MessageBus& bus,
                      const std::string& channel,
                      const std::string& rig,
                      const RigKey& key) {
  core::Random random(8);
  int sent = 0;
  for (const bool with_key : {false, true}) {
    const WireMessage wire = MakeWireMessage<Message>(random);
    std::vector<std::size_t> places = wire.strings;
    places.insert(places.end(), wire.counts.begin(), wire.counts.end());
    for (const std::size_t at : places) {
      for (const std::int32_t length : kBadLengths) {
        std::vector<std::uint8_t> bytes = wire.bytes;
        PutInt(bytes, at, length);
        bus.Publish(channel, with_key ? SealBytes(bytes, channel, rig, key) : bytes);
        ++sent;
      }
    }
  }
  return sent;
}

TEST(Network, ADatagramWithABadLengthHarmsNeitherServerNorAgent) {
  AgentHere agent("net-9", 1.0, 0.0);
  const auto finder = Finder(kAgentPort, "here");
  const auto rig = WaitFor(*finder, "net-9");
  const RigKey key = LoadOrMakeRigKey(KeyFolder(), "net-9").value();
  const auto bus = OpenLcmBus(Url(kAgentPort)).value();
  int sent = PublishBadLengths<faultlab_msgs::rig_announce_t>(*bus, kAnnounceChannel, "net-9", key);
  // Messages of a rig whose key is known here.
  {
    faultlab_msgs::rig_announce_t own{};
    own.rig = "net-9";
    std::vector<std::uint8_t> bytes = ToBytes(own);
    constexpr std::size_t kClassAt = kMessageHashBytes + 4 + 6 + 3 * 8;
    for (const std::int32_t length : kBadLengths) {
      PutInt(bytes, kClassAt, length);
      bus->Publish(kAnnounceChannel, SealBytes(bytes, kAnnounceChannel, "net-9", key));
      ++sent;
    }
  }
  sent +=
      PublishBadLengths<faultlab_msgs::rig_command_t>(*bus, CommandChannel("net-9"), "net-9", key);
  sent += PublishBadLengths<faultlab_msgs::rig_reply_t>(*bus, ReplyChannel("net-9"), "net-9", key);
  sent +=
      PublishBadLengths<faultlab_msgs::rig_stream_t>(*bus, StreamChannel("net-9"), "net-9", key);
  EXPECT_GT(sent, 300);
  ASSERT_TRUE(rig->Arm(SquarePlan(20), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  ExpectEveryIndex(Drain(*rig), 20);
  EXPECT_GT(agent.Stop().forged, 0u);
  EXPECT_EQ(finder->List().size(), 1u) << "a broken announcement is no rig";
}

TEST(Network, NoDatagramHarmsServerOrAgent) {
  AgentHere agent("net-10", 1.0, 0.0);
  const auto finder = Finder(kAgentPort, "here");
  const auto rig = WaitFor(*finder, "net-10");
  UdpProbe probe(kAgentPort);
  for (const std::string& channel : {std::string(kAnnounceChannel),
                                     CommandChannel("net-10"),
                                     ReplyChannel("net-10"),
                                     StreamChannel("net-10")}) {
    const std::vector<Datagram> bad = BadDatagrams(channel);
    EXPECT_GT(bad.size(), 700u);
    for (const Datagram& datagram : bad) probe.Send(datagram);
    for (std::size_t size = 0; size < bad[0].size(); ++size) {
      probe.Send(std::span(bad[0]).first(size));
    }
  }
  ASSERT_TRUE(rig->Arm(SquarePlan(20), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  ExpectEveryIndex(Drain(*rig), 20);
}

TEST(Network, SeveralAgentsAndTwoServersFindEachOther) {
  AgentHere one("net-7a", 1.0, 0.0);
  AgentHere two("net-7b", 1.0, 0.0);
  const auto first = Finder(kAgentPort, "first");
  const auto second = Finder(kAgentPort, "second");
  const auto mine = WaitFor(*first, "net-7a");
  const auto theirs = WaitFor(*second, "net-7a");
  (void)WaitFor(*second, "net-7b");
  EXPECT_EQ(first->Find("net-7c"), nullptr);
  ASSERT_TRUE(mine->Arm(SquarePlan(50), kEpoch).ok());
  EXPECT_EQ(theirs->Arm(SquarePlan(10), Epoch{9}).error().code, core::ErrorCode::kBusy);
  ASSERT_TRUE(second->Find("net-7b")->Arm(SquarePlan(10), kEpoch).ok());
  ASSERT_TRUE(mine->Start(kEpoch).ok());
  ExpectEveryIndex(Drain(*mine), 50);
}

/// Compares the received part of `sent`: UDP may lose samples, but each received one is exact and
/// every loss is counted.
void ExpectHeard(const LcmRecord& heard, const std::vector<core::Sample>& sent) {
  ASSERT_GT(heard.samples.size(), sent.size() / 2) << "lost more than a busy machine explains";
  for (const core::Sample& sample : heard.samples) {
    const auto same = std::find_if(sent.begin(), sent.end(), [&](const core::Sample& one) {
      return one.index == sample.index;
    });
    ASSERT_NE(same, sent.end()) << "sample " << sample.index << " was never sent";
    ASSERT_EQ(sample.um_v, same->um_v);
  }
  // Losses after the last received sample cannot be known.
  const auto first_unheard = std::find_if(sent.begin(), sent.end(), [&](const core::Sample& one) {
    return one.index > heard.samples.back().index;
  });
  EXPECT_EQ(static_cast<std::int64_t>(heard.samples.size()) + heard.lost_samples,
            first_unheard - sent.begin());
}

TEST(Network, ATappedRunIsRecordedByLcmLoggerAndPlayedByLcmLogplayer) {
  const std::string path = testing::TempDir() + "/network_tap.lcm";
  const std::string again = testing::TempDir() + "/network_tap_again.lcm";
  auto tap = LcmTap::Open(Url(kAgentPort));
  ASSERT_TRUE(tap.ok());
  auto logger = std::make_unique<Logger>(path);
  const auto has_bytes = [](const std::string& file) {
    std::error_code none;
    return std::filesystem::exists(file, none) && std::filesystem::file_size(file, none) > 0;
  };
  {
    // Waits until the logger listens: its file grows.
    LcmTap::Stream hello(*tap.value(), "net-8", "hello", kEpoch);
    while (!has_bytes(path)) {
      PublishPaced(hello);
      ASSERT_TRUE(logger->runs()) << "lcm-logger (liblcm-bin) does not run";
    }
  }
  LcmTap::Stream stream(*tap.value(), "net-8", "run", kEpoch);
  SimulatedRigOptions options;
  options.speed = 2.0;
  const auto rig = MakeSimulatedRig(options);
  ASSERT_TRUE(rig->Arm(SquarePlan(200), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  const RunLog run = Drain(*rig, [&](const core::Sample& sample) {
    stream.Publish(core::Frame{.sample = sample, .estimates = {}});
  });
  // lcm-logger writes every 100 ms; a marker after the run shows that the run is complete.
  LcmTap::Stream marker(*tap.value(), "net-8", "marker", kEpoch);
  while (!ReadLcmLog(path, "marker", paper::Bench()).ok()) PublishPaced(marker);
  logger.reset();
  const auto record = ReadLcmLog(path, "run", paper::Bench());
  ASSERT_TRUE(record.ok()) << record.error().message;
  ExpectHeard(record.value(), run.samples);

  LcmRecord export_record = record.value();
  export_record.run = "exported";
  ASSERT_TRUE(WriteLcmLog(path, export_record, 1'000'000).ok());
  logger = std::make_unique<Logger>(again);
  {
    LcmTap::Stream hello(*tap.value(), "net-8", "hello", kEpoch);
    while (!has_bytes(again)) {
      PublishPaced(hello);
      ASSERT_TRUE(logger->runs()) << "lcm-logger (liblcm-bin) does not run";
    }
  }
  const std::string play =
      "lcm-logplayer --lcm-url='" + Url(kAgentPort) + "' " + path + " > /dev/null";
  ASSERT_EQ(std::system(play.c_str()), 0);
  while (!ReadLcmLog(again, "marker", paper::Bench()).ok()) PublishPaced(marker);
  logger.reset();
  const auto played = ReadLcmLog(again, "exported", paper::Bench());
  ASSERT_TRUE(played.ok()) << played.error().message;
  ExpectHeard(played.value(), export_record.samples);
}

}  // namespace
}  // namespace faultlab::hardware
