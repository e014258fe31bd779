#include "hardware/lcm/lcm_packet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/hardware/lcm_datagrams.h"

namespace faultlab::hardware {
namespace {

constexpr std::uint32_t kOdd[] = {0, 1, 2, 3000, 0x7fffffff, 0x80000000, 0xfffffff0, 0xffffffff};

TEST(LcmPacket, WithAWholeMessageIsRead) {
  const Datagram datagram = ShortDatagram(7, std::string("CHANNEL\0abc", 11));
  const auto packet = ReadLcmPacket(datagram);
  ASSERT_TRUE(packet.has_value());
  EXPECT_EQ(packet->sequence, 7u);
  EXPECT_EQ(packet->channel, "CHANNEL");
  EXPECT_EQ(std::string(packet->payload.begin(), packet->payload.end()), "abc");
  EXPECT_EQ(packet->count, 1u);
  EXPECT_EQ(packet->message_bytes, 3u);
}

TEST(LcmPacket, MayHaveAnEmptyMessageAndAChannelOf63BytesButNotOf64) {
  EXPECT_TRUE(ReadLcmPacket(ShortDatagram(0, std::string("A\0", 2))).has_value());
  EXPECT_TRUE(ReadLcmPacket(ShortDatagram(0, std::string(63, 'c') + '\0')).has_value());
  EXPECT_FALSE(ReadLcmPacket(ShortDatagram(0, std::string(64, 'c') + '\0')).has_value());
}

TEST(LcmPacket, WithoutAnEndOfItsChannelIsRefused) {
  EXPECT_FALSE(ReadLcmPacket(ShortDatagram(0, "")).has_value());
  EXPECT_FALSE(ReadLcmPacket(ShortDatagram(0, "CHANNEL")).has_value());
  EXPECT_FALSE(ReadLcmPacket(FragmentDatagram({.size = 10, .count = 2}, "CHANNEL")).has_value());
  EXPECT_FALSE(ReadLcmPacket(FragmentDatagram({.size = 10, .count = 2}, "")).has_value());
}

TEST(LcmPacket, CutAnywhereInItsHeadIsRefused) {
  const Datagram whole = ShortDatagram(7, std::string("CH\0", 3));
  const Datagram fragment = FragmentDatagram({.size = 10, .count = 2}, std::string("CH\0a", 4));
  ASSERT_TRUE(ReadLcmPacket(whole).has_value());
  ASSERT_TRUE(ReadLcmPacket(fragment).has_value());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(ReadLcmPacket(Datagram(whole.begin(), whole.begin() + size)).has_value());
  }
  for (std::size_t size = 0; size < fragment.size(); ++size) {
    EXPECT_FALSE(ReadLcmPacket(Datagram(fragment.begin(), fragment.begin() + size)).has_value());
  }
}

TEST(LcmPacket, OfAnotherMagicIsRefused) {
  Datagram datagram = ShortDatagram(7, std::string("CH\0", 3));
  datagram[3] = '4';
  EXPECT_FALSE(ReadLcmPacket(datagram).has_value());
}

/// The datagram that crashes liblcm: offset + size is 82 in 32 bits.
TEST(LcmPacket, WhoseOffsetWrapsIn32BitsIsRefused) {
  const std::string body = std::string("FAULTLAB.ANNOUNCE\0", 18) + std::string(100, 'x');
  EXPECT_FALSE(
      ReadLcmPacket(
          FragmentDatagram({.sequence = 7, .size = 3000, .offset = 0xffffffff, .count = 2}, body))
          .has_value());
}

TEST(LcmPacket, KeepsItsPromisesForEveryOddNumber) {
  int taken = 0;
  for (const std::uint32_t size : kOdd) {
    for (const std::uint32_t offset : kOdd) {
      for (const std::uint32_t number : kOdd) {
        for (const std::uint32_t count : kOdd) {
          for (const std::string& body :
               {std::string(), std::string("A\0", 2), std::string("A\0xy", 4)}) {
            const Datagram datagram =
                FragmentDatagram({.sequence = 1,
                                  .size = size,
                                  .offset = offset,
                                  .number = static_cast<std::uint16_t>(number),
                                  .count = static_cast<std::uint16_t>(count)},
                                 body);
            const auto packet = ReadLcmPacket(datagram);
            if (!packet) continue;
            ++taken;
            ASSERT_GT(packet->payload.size(), 0u);
            ASSERT_LE(std::uint64_t{offset} + packet->payload.size(), size);
            ASSERT_LE(size, kLcmMessageBytesMax);
            ASSERT_LT(packet->number, packet->count);
            ASSERT_LE(packet->count, kLcmFragmentsMax);
          }
        }
      }
    }
  }
  EXPECT_GT(taken, 5);
}

TEST(LcmPacket, MeetsEachBoundExactly) {
  const std::string body("A\0xy", 4);  // 2 bytes of message
  const auto taken = [&](FragmentHead head) {
    return ReadLcmPacket(FragmentDatagram(head, body)).has_value();
  };
  EXPECT_TRUE(taken({.size = kLcmMessageBytesMax, .count = 2}));
  EXPECT_FALSE(taken({.size = kLcmMessageBytesMax + 1, .count = 2}));
  EXPECT_TRUE(taken({.size = 5000, .count = kLcmFragmentsMax}));
  EXPECT_FALSE(taken({.size = 5000, .count = kLcmFragmentsMax + 1}));
  EXPECT_TRUE(taken({.size = 10, .offset = 8, .count = 2}));
  EXPECT_FALSE(taken({.size = 10, .offset = 9, .count = 2}));
  EXPECT_TRUE(taken({.size = 10, .number = 1, .count = 2}));
  EXPECT_FALSE(taken({.size = 10, .number = 2, .count = 2}));
  EXPECT_TRUE(taken({.size = 2, .count = 1}));
  EXPECT_FALSE(taken({.size = 3, .count = 1})) << "the only fragment is the whole message";
}

TEST(LcmPacket, IsCutWhereLiblcmCuts) {
  struct Case {
    std::size_t message;
    std::vector<std::size_t> payloads;
  };
  // liblcm 1.3.1, lcm_udpm.c: channel, NUL and message in 65499 bytes, else fragments of 65487.
  const Case cases[] = {{0, {0}},
                        {65'496, {65'496}},
                        {65'497, {65'484, 13}},
                        {2 * 65'487 - 3, {65'484, 65'487}},
                        {2 * 65'487 - 2, {65'484, 65'487, 1}}};
  for (const Case& one : cases) {
    const std::vector<std::uint8_t> message = SomeBytes(one.message);
    const auto datagrams = DatagramsOf(9, "CH", message);
    ASSERT_EQ(datagrams.size(), one.payloads.size()) << one.message;
    std::vector<std::uint8_t> joined;
    for (std::size_t i = 0; i < datagrams.size(); ++i) {
      EXPECT_LE(datagrams[i].size(), 65'507u) << "UDP takes no more";
      const auto packet = ReadLcmPacket(datagrams[i]);
      ASSERT_TRUE(packet.has_value());
      EXPECT_EQ(packet->sequence, 9u);
      EXPECT_EQ(packet->payload.size(), one.payloads[i]);
      EXPECT_EQ(packet->offset, joined.size());
      EXPECT_EQ(packet->number, i);
      EXPECT_EQ(packet->count, datagrams.size());
      joined.insert(joined.end(), packet->payload.begin(), packet->payload.end());
    }
    EXPECT_EQ(joined, message);
  }
}

TEST(LcmPacket, IsNotWrittenBeyondItsBounds) {
  int sent = 0;
  const auto count = [&](auto, auto) { ++sent; };
  EXPECT_FALSE(WriteLcmPackets(0, "CH", SomeBytes(kLcmMessageBytesMax + 1), count));
  EXPECT_FALSE(WriteLcmPackets(0, std::string(64, 'c'), {}, count));
  EXPECT_FALSE(WriteLcmPackets(0, std::string("a\0b", 3), {}, count));
  EXPECT_EQ(sent, 0);
  EXPECT_TRUE(WriteLcmPackets(0, std::string(63, 'c'), SomeBytes(kLcmMessageBytesMax), count));
  EXPECT_EQ(sent, 17);
}

}  // namespace
}  // namespace faultlab::hardware
