// What a host on the bus's network can learn and forge.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "faultlab_msgs/rig_announce_t.hpp"
#include "faultlab_msgs/rig_command_t.hpp"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/rig_codec.h"
#include "hardware/lcm/sealed_message.h"
#include "hardware/lcm/unproven_rigs.h"
#include "tests/paper_bench.h"
#include "tests/support/await.h"
#include "tests/system/network/network_world.h"
#include "tests/system/network/udp_relay.h"

namespace faultlab::hardware {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr Epoch kEpoch{1};
constexpr double kValue = 123.456789;

/// As encoded by LCM in a message.
Bytes OnTheWire(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  Bytes bytes;
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(bits >> shift));
  }
  return bytes;
}
Bytes OnTheWire(std::string_view text) {
  Bytes bytes = {0, 0, 0, static_cast<std::uint8_t>(text.size() + 1)};
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.push_back(0);
  return bytes;
}
bool Contains(const Bytes& bytes, const Bytes& part) {
  return std::search(bytes.begin(), bytes.end(), part.begin(), part.end()) != bytes.end();
}

TEST(BusSecrecy, NoDatagramOfARunHoldsItsPlanItsFaultOrWhatTheRelayAnswered) {
  AgentHere agent("dark-1", 1.0, 30.0);
  UdpProbe probe(kAgentPort);
  const auto finder = Finder(kAgentPort, "here");
  const auto rig = WaitFor(*finder, "dark-1");
  RunPlan plan = SquarePlan(150);
  plan.faults = {{.component = paper::kR1, .value = kValue, .at_s = 0.5}};
  faultlab_msgs::rig_command_t arm{};
  arm.uc_v = plan.uc_v;
  arm.uc_count = static_cast<std::int32_t>(plan.uc_v.size());
  arm.faults = {ToMessage(plan.faults[0])};
  arm.fault_count = 1;
  arm.action = "fault_commanded";
  std::vector<Bytes> secrets = {
      OnTheWire("R1"), OnTheWire(kValue), OnTheWire("arm"), OnTheWire("fault_commanded")};
  for (const double volts : plan.uc_v) secrets.push_back(OnTheWire(volts));
  for (const Bytes& secret : {secrets[0], secrets[1], secrets[3], secrets[4]}) {
    ASSERT_TRUE(Contains(ToBytes(arm), secret)) << "the search finds nothing in the clear either";
  }

  const core::Status armed = rig->Arm(plan, kEpoch);
  ASSERT_TRUE(armed.ok()) << armed.error().message;
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  const RunLog log = Drain(*rig);
  ExpectEveryIndex(log, 150);
  ASSERT_FALSE(log.Of(RigEventKind::kFaultCommanded).empty());

  std::map<std::string, int> heard;  // messages received, by channel
  while (const auto datagram = probe.Receive()) {
    for (const std::string& channel : {std::string(kAnnounceChannel),
                                       CommandChannel("dark-1"),
                                       ReplyChannel("dark-1"),
                                       StreamChannel("dark-1")}) {
      heard[channel] += Contains(*datagram, Bytes(channel.begin(), channel.end())) ? 1 : 0;
    }
    for (const Bytes& secret : secrets) ASSERT_FALSE(Contains(*datagram, secret));
  }
  EXPECT_EQ(heard.size(), 4u);
  for (const auto& [channel, count] : heard) EXPECT_GT(count, 0) << channel;
  EXPECT_GT(heard[StreamChannel("dark-1")], 20);
}

/// An announcement that anybody can send: unsealed, or sealed with a key of their own.
Bytes Forged(const std::string& name, bool sealed) {
  faultlab_msgs::rig_announce_t said{};
  said.rig = name;
  said.rig_class = "\xff\xfe no UTF-8";
  said.state = "idle";
  RigKey key;
  key.fill(0x66);
  return sealed ? Sealed(said, kAnnounceChannel, key) : ToBytes(said);
}

TEST(BusSecrecy, TenThousandInventedNamesAreBoundedAndShutNoRigOut) {
  const auto finder = Finder(kAgentPort, "here");
  const auto bus = OpenLcmBus(Url(kAgentPort)).value();
  std::unique_ptr<AgentHere> agent;
  std::size_t most = 0;
  for (int i = 0; i < 10'500; ++i) {
    const std::string name =
        i % 100 < 4 ? "sim-" + std::to_string(i % 100 + 1) : "invented-" + std::to_string(i);
    bus->Publish(kAnnounceChannel, Forged(name, i % 2 == 0));
    bus->Publish(kAnnounceChannel,
                 Forged("bright-1", i % 2 == 0));  // of the rig that appears later
    if (i % 500 == 0) most = std::max(most, finder->Unkeyed().size());
    if (i == 5000) agent = std::make_unique<AgentHere>("bright-1", 1.0, 30.0);
  }
  const auto rig = WaitFor(*finder, "bright-1");
  EXPECT_GT(most, 1u) << "nobody heard the flood";
  EXPECT_LE(most, UnprovenRigs::kNamesMax);
  ASSERT_EQ(finder->List().size(), 1u) << "a name is no rig";
  EXPECT_EQ(finder->Find("sim-1"), nullptr);
  for (const RemoteRigInfo& info : finder->Unkeyed()) {
    EXPECT_NE(info.description.id, "bright-1") << "it is proved now";
    EXPECT_EQ(info.description.rig_class, "");
    EXPECT_FALSE(info.key_known);
  }
  ASSERT_TRUE(rig->Arm(SquarePlan(20), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  ExpectEveryIndex(Drain(*rig), 20);
}

TEST(BusSecrecy, AKeyThatIsCopiedLaterOpensTheRigWithoutARestart) {
  const std::string folder = KeyFolder() + "_later";
  std::filesystem::create_directories(folder);
  AgentHere agent("later-1", 1.0, 30.0);
  const auto finder =
      OpenRigFinder(
          {.lcm_url = Url(kAgentPort), .key_directory = folder, .lab = "", .server_name = "here"})
          .value();
  ASSERT_TRUE(tests::Await([&] { return !finder->Unkeyed().empty(); }));
  const RemoteRigInfo name = finder->Unkeyed().at(0);
  EXPECT_EQ(name.description.id, "later-1");
  EXPECT_EQ(name.refusal, RigRefusal::kNoKey);
  EXPECT_NE(name.refusal_text.find("copy its .key file"), std::string::npos) << name.refusal_text;
  EXPECT_TRUE(finder->List().empty());
  std::filesystem::copy(KeyFolder() + "/later-1.key", folder + "/later-1.key");
  const auto rig = WaitFor(*finder, "later-1");
  EXPECT_TRUE(finder->Unkeyed().empty());
  EXPECT_TRUE(rig->Arm(SquarePlan(20), kEpoch).ok());
  std::filesystem::remove_all(folder);
}

TEST(BusSecrecy, AnAgentThatHasAnotherKeyNowIsSaidToAndFoundAgainWhenThatIsCopied) {
  const std::string folder = KeyFolder() + "_server";
  std::filesystem::create_directories(folder);
  const std::string file = "/renewed-1.key";
  const auto finder =
      OpenRigFinder(
          {.lcm_url = Url(kAgentPort), .key_directory = folder, .lab = "", .server_name = "here"})
          .value();
  {
    AgentHere agent("renewed-1", 1.0, 0.0);
    std::filesystem::copy(KeyFolder() + file, folder + file);
    (void)WaitFor(*finder, "renewed-1");
  }
  std::filesystem::remove(KeyFolder() + file);
  AgentHere again("renewed-1", 1.0, 0.0);  // makes a key of its own
  ASSERT_TRUE(
      tests::Await([&] { return InfoOf(*finder, "renewed-1").refusal == RigRefusal::kOtherKey; }));
  std::filesystem::copy(
      KeyFolder() + file, folder + file, std::filesystem::copy_options::overwrite_existing);
  const auto rig = WaitFor(*finder, "renewed-1");
  EXPECT_FALSE(InfoOf(*finder, "renewed-1").refusal);
  ASSERT_TRUE(rig->Arm(SquarePlan(20), kEpoch).ok());
  ASSERT_TRUE(rig->Start(kEpoch).ok());
  ExpectEveryIndex(Drain(*rig), 20);
  std::filesystem::remove_all(folder);
}

TEST(BusSecrecy, AnAgentOfAnotherVersionIsNamedWithWhatToDo) {
  const std::string folder = KeyFolder() + "_older";
  std::filesystem::create_directories(folder);
  const RigKey key = LoadOrMakeRigKey(folder, "older-1").value();
  const auto finder =
      OpenRigFinder(
          {.lcm_url = Url(kAgentPort), .key_directory = folder, .lab = "", .server_name = "here"})
          .value();
  const auto bus = OpenLcmBus(Url(kAgentPort)).value();
  ASSERT_TRUE(tests::Await([&] {
    bus->Publish(kAnnounceChannel,
                 SealBytes(Bytes(300, 7), kAnnounceChannel, "older-1", key, kProtocol - 1));
    return !finder->Unkeyed().empty();
  }));
  const RemoteRigInfo rig = finder->Unkeyed().at(0);
  EXPECT_EQ(rig.description.id, "older-1");
  EXPECT_NE(rig.refusal_text.find("update the older one"), std::string::npos) << rig.refusal_text;
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace faultlab::hardware
