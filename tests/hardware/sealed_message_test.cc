#include "hardware/lcm/sealed_message.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "faultlab_msgs/rig_announce_t.hpp"
#include "faultlab_msgs/rig_command_t.hpp"
#include "faultlab_msgs/rig_sealed_t.hpp"
#include "hardware/lcm/rig_codec.h"
#include "tests/hardware/lcm_datagrams.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

constexpr const char* kRig = "bench-1";
const std::string kChannel = CommandChannel(kRig);

RigKey SomeKey() {
  RigKey key;
  key.fill(0x33);
  return key;
}

bool Contains(const std::vector<std::uint8_t>& bytes, std::string_view text) {
  return std::search(bytes.begin(), bytes.end(), text.begin(), text.end()) != bytes.end();
}

TEST(SealedMessage, IsOpenedWithItsKeyOnItsChannelAsItsRigAlone) {
  for (const std::size_t size : {0, 1, 255, 256, 257, 5000}) {
    const std::vector<std::uint8_t> message = SomeBytes(size);
    const auto bytes = SealBytes(message, kChannel, kRig, SomeKey());
    const auto opened = OpenSealed(bytes, kChannel, kRig, SomeKey());
    ASSERT_TRUE(opened.has_value()) << size;
    EXPECT_EQ(opened->message, message);
    EXPECT_EQ(opened->protocol, kProtocol);
    EXPECT_FALSE(OpenSealed(bytes, kChannel, kRig, RigKey{}).has_value());
    EXPECT_FALSE(OpenSealed(bytes, ReplyChannel(kRig), kRig, SomeKey()).has_value());
    EXPECT_FALSE(OpenSealed(bytes, kChannel, "bench-2", SomeKey()).has_value());
    EXPECT_TRUE(FromBytes<faultlab_msgs::rig_sealed_t>(bytes).has_value()) << "an LCM message";
  }
}

TEST(SealedMessage, WithOneBitTurnedDoesNotOpen) {
  auto bytes = SealBytes(SomeBytes(100), kChannel, kRig, SomeKey());
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    EXPECT_FALSE(OpenSealed(bytes, kChannel, kRig, SomeKey()).has_value()) << bit;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
  }
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(OpenSealed(std::span(bytes).first(size), kChannel, kRig, SomeKey()).has_value());
  }
}

TEST(SealedMessage, TellsNeitherComponentNorValueNorHowManyFaultsThereAre) {
  std::set<std::size_t> sizes;
  for (int faults = 0; faults <= 2; ++faults) {
    faultlab_msgs::rig_command_t arm{};
    arm.rig = kRig;
    arm.action = "arm";
    for (int i = 0; i < faults; ++i) {
      arm.faults.push_back(ToMessage({.component = paper::kR12, .value = 23456.5}));
    }
    arm.fault_count = faults;
    const auto plain = ToBytes(arm);
    const auto bytes = Sealed(arm, kChannel, SomeKey());
    EXPECT_NE(bytes, Sealed(arm, kChannel, SomeKey())) << "the same twice is not seen";
    EXPECT_EQ(Contains(plain, "R12"), faults > 0);
    EXPECT_FALSE(Contains(bytes, "R12"));
    EXPECT_FALSE(Contains(bytes, "arm"));
    sizes.insert(bytes.size());
  }
  EXPECT_EQ(sizes.size(), 1u);
}

TEST(SealedMessage, IsAsLongWithTheEventsOfAFaultAsWithoutAndWithManyFaultsAsWithNone) {
  const auto piece_with = [](int events) {
    faultlab_msgs::rig_stream_t piece{};
    piece.rig = kRig;
    piece.items.push_back(ToItem(core::Sample{.index = 600, .t_s = 6.0}));
    for (int i = 0; i < events; ++i) {
      piece.items.push_back(ToItem(RigEvent{
          .kind = RigEventKind::kFaultCommanded, .component = paper::kR12, .text = "scheduled"}));
    }
    piece.count = static_cast<std::int32_t>(piece.items.size());
    return Sealed(piece, StreamChannel(kRig), SomeKey()).size();
  };
  EXPECT_EQ(piece_with(0), piece_with(2));
  EXPECT_EQ(piece_with(0), piece_with(4));
  const auto arm_with = [](int faults) {
    faultlab_msgs::rig_command_t arm{};
    arm.rig = kRig;
    arm.action = "arm";
    for (int i = 0; i < faults; ++i) {
      arm.faults.push_back(ToMessage({.component = paper::kR12, .value = 23456.5}));
    }
    arm.fault_count = faults;
    return Sealed(arm, kChannel, SomeKey()).size();
  };
  EXPECT_EQ(arm_with(0), arm_with(64));
}

TEST(SealedMessage, NamesItsRigBeforeItIsBelieved) {
  const auto bytes = SealBytes({}, kChannel, kRig, SomeKey());
  EXPECT_EQ(SealedRig(bytes), kRig);
  for (std::size_t size = 0; size < kMessageHashBytes + 4 + 8; ++size) {
    EXPECT_FALSE(SealedRig(std::span(bytes).first(size)).has_value()) << size;
  }
}

faultlab_msgs::rig_announce_t Announcement() {
  faultlab_msgs::rig_announce_t said{};
  said.rig = kRig;
  said.rig_class = "\u043A\u043B\u0443\u043F\u0430";  // any UTF-8
  return said;
}

auto Read(const faultlab_msgs::rig_announce_t& said, const RigKey& key = SomeKey()) {
  return ReadAnnouncement(Sealed(said, kAnnounceChannel, SomeKey()), kRig, key);
}

TEST(Announcement, IsReadWithItsKeyAlone) {
  EXPECT_TRUE(Read(Announcement()).has_value());
  EXPECT_FALSE(Read(Announcement(), RigKey{}).has_value());
  EXPECT_FALSE(ReadAnnouncement(ToBytes(Announcement()), kRig, SomeKey()).has_value());
  const auto bytes = Sealed(Announcement(), kAnnounceChannel, SomeKey());
  EXPECT_FALSE(IsForeignProtocol(bytes, kRig, SomeKey()));
  auto other = Announcement();
  other.rig = "bench-2";
  EXPECT_FALSE(ReadAnnouncement(
                   SealBytes(ToBytes(other), kAnnounceChannel, kRig, SomeKey()), kRig, SomeKey())
                   .has_value());
}

TEST(Announcement, WithATextThatIsNotUtf8OrTooLongIsRefusedButForADriversOwnWords) {
  faultlab_msgs::rig_announce_t said = Announcement();
  said.trip_text = "R\xe9sistance";
  const auto read = Read(said);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->trip_text, "(not UTF-8)");
  said.rig_class = "am\xe9";
  EXPECT_FALSE(Read(said).has_value());
  said.rig_class = std::string(201, 'a');
  EXPECT_FALSE(Read(said).has_value());
}

}  // namespace
}  // namespace faultlab::hardware
