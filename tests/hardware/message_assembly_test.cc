#include "hardware/lcm/message_assembly.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/signals/random.h"
#include "tests/hardware/lcm_datagrams.h"

namespace faultlab::hardware {
namespace {

constexpr LcmSender kHere{.address = 1, .port = 1000};
constexpr LcmSender kThere{.address = 1, .port = 1001};

class MessageAssemblyTest : public testing::Test {
 protected:
  std::optional<LcmMessage> Add(const LcmSender& sender, const Datagram& datagram) {
    const auto packet = ReadLcmPacket(datagram);
    EXPECT_TRUE(packet.has_value());
    return packet ? assembly_.Add(sender, *packet) : std::nullopt;
  }
  /// Adds all fragments, one of which must complete a message.
  std::optional<LcmMessage> AddAll(const LcmSender& sender, const std::vector<Datagram>& all) {
    std::optional<LcmMessage> message;
    for (const Datagram& datagram : all) {
      if (auto done = Add(sender, datagram)) message = std::move(done);
    }
    return message;
  }
  /// A piece of the message "CH" of 10 bytes, with any numbers.
  static Datagram Piece(std::uint16_t number,
                        std::uint16_t count,
                        std::uint32_t offset,
                        const std::string& bytes,
                        std::uint32_t size = 10) {
    const std::string head = number == 0 ? std::string("CH\0", 3) : std::string();
    return FragmentDatagram(
        {.sequence = 5, .size = size, .offset = offset, .number = number, .count = count},
        head + bytes);
  }
  static std::string Text(const std::optional<LcmMessage>& message) {
    return message ? std::string(message->bytes.begin(), message->bytes.end()) : "nothing";
  }

  bool wanted_ = true;
  MessageAssembly assembly_{[this](std::string_view) { return wanted_; }};
};

TEST_F(MessageAssemblyTest, JoinsAMessageFromItsFragmentsInAnyOrder) {
  const std::vector<std::uint8_t> bytes = SomeBytes(300'000);
  core::Random random(3);
  std::vector<Datagram> datagrams = DatagramsOf(0, "CH", bytes);
  ASSERT_EQ(datagrams.size(), 5u);
  for (std::uint32_t sequence = 0; sequence < 50; ++sequence) {
    datagrams = DatagramsOf(sequence, "CH", bytes);
    for (std::size_t i = datagrams.size(); i > 1; --i) {
      std::swap(datagrams[i - 1], datagrams[random.Below(i)]);
    }
    for (std::size_t i = 0; i < datagrams.size(); ++i) {
      const auto message = Add(kHere, datagrams[i]);
      ASSERT_EQ(message.has_value(), i + 1 == datagrams.size());
      if (!message) continue;
      EXPECT_EQ(message->channel, "CH");
      EXPECT_EQ(message->bytes, bytes);
    }
  }
  EXPECT_EQ(assembly_.open_bytes(), 0u);
}

TEST_F(MessageAssemblyTest, CountsADoubledFragmentOnceAlsoBehindTheEnd) {
  EXPECT_FALSE(Add(kHere, Piece(0, 2, 0, "abcd")));
  EXPECT_FALSE(Add(kHere, Piece(0, 2, 0, "abcd")));
  EXPECT_FALSE(Add(kHere, Piece(0, 2, 0, "XXXX"))) << "the first one counts";
  EXPECT_EQ(Text(Add(kHere, Piece(1, 2, 4, "efghij"))), "abcdefghij");
  EXPECT_FALSE(Add(kHere, Piece(1, 2, 4, "efghij")));
  EXPECT_FALSE(Add(kHere, Piece(0, 2, 0, "abcd")));
  EXPECT_EQ(assembly_.open_bytes(), 0u);
}

TEST_F(MessageAssemblyTest, GivesNothingWhileAFragmentIsMissing) {
  EXPECT_FALSE(Add(kHere, Piece(0, 3, 0, "abcd")));
  EXPECT_FALSE(Add(kHere, Piece(2, 3, 8, "ij")));
  EXPECT_EQ(assembly_.open_bytes(), 10u);
  EXPECT_EQ(Text(Add(kHere, Piece(1, 3, 4, "efgh"))), "abcdefghij");
}

TEST_F(MessageAssemblyTest, KeepsSendersApart) {
  const auto one = SomeBytes(200'000, 1);
  const auto two = SomeBytes(200'000, 2);
  const auto from_here = DatagramsOf(5, "ONE", one);
  const auto from_there = DatagramsOf(5, "TWO", two);
  ASSERT_EQ(from_here.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto here = Add(kHere, from_here[i]);
    const auto there = Add(kThere, from_there[3 - i]);
    ASSERT_EQ(here.has_value(), i == 3);
    ASSERT_EQ(there.has_value(), i == 3);
    if (i < 3) continue;
    EXPECT_EQ(here->channel, "ONE");
    EXPECT_EQ(here->bytes, one);
    EXPECT_EQ(there->channel, "TWO");
    EXPECT_EQ(there->bytes, two);
  }
}

TEST_F(MessageAssemblyTest, RefusesAFragmentThatDisagreesWithTheFirst) {
  EXPECT_FALSE(Add(kHere, Piece(0, 2, 0, "abcd")));
  EXPECT_FALSE(Add(kHere, Piece(1, 2, 4, "ZZZZZZ", 11))) << "another size";
  EXPECT_FALSE(Add(kHere, Piece(1, 3, 4, "ZZZZZZ"))) << "another count";
  EXPECT_EQ(Text(Add(kHere, Piece(1, 2, 4, "efghij"))), "abcdefghij");
}

TEST_F(MessageAssemblyTest, RefusesAMessageWhoseFragmentsOverlapOrLeaveAHole) {
  const std::vector<std::vector<Datagram>> bad = {
      {Piece(0, 2, 0, "abcd"), Piece(1, 2, 3, "efghij")},                          // overlap
      {Piece(0, 2, 0, "abcd"), Piece(1, 2, 5, "ghij"), Piece(1, 2, 4, "efghij")},  // hole
      {Piece(0, 2, 1, "abcd"), Piece(1, 2, 4, "efghij")},                          // not from 0
      {Piece(0, 2, 6, "ghij"), Piece(1, 2, 0, "abcdef")},                          // exchanged
      {Piece(0, 2, 0, "abcd"), Piece(1, 2, 4, "efghi")},                           // too short
      {Piece(0, 3, 0, "abcdefghij"), Piece(1, 3, 0, "abcdefghij")},                // too much
  };
  for (std::size_t i = 0; i < bad.size(); ++i) {
    MessageAssembly assembly([](std::string_view) { return true; });
    for (const Datagram& datagram : bad[i]) {
      const auto packet = ReadLcmPacket(datagram);
      ASSERT_TRUE(packet.has_value()) << i;
      EXPECT_FALSE(assembly.Add(kHere, *packet).has_value()) << i;
    }
    EXPECT_EQ(assembly.open_bytes(), 0u) << i;
  }
}

TEST_F(MessageAssemblyTest, HoldsNothingOfAChannelThatNobodyWants) {
  wanted_ = false;
  const auto datagrams = DatagramsOf(0, "OTHER", SomeBytes(300'000));
  EXPECT_FALSE(Add(kHere, datagrams[1])) << "its channel is not known yet";
  EXPECT_EQ(assembly_.open_bytes(), 300'000u);
  EXPECT_FALSE(AddAll(kHere, datagrams).has_value());
  EXPECT_EQ(assembly_.open_bytes(), 0u);
}

TEST_F(MessageAssemblyTest, DropsTheOldestBeyondTheNumberOfPartialMessages) {
  constexpr std::uint32_t kMessages = 1u << 16;
  const auto first = [](std::uint32_t sequence) {
    return FragmentDatagram({.sequence = sequence, .size = 3, .count = 2},
                            std::string("CH\0ab", 5));
  };
  const auto last = [](std::uint32_t sequence) {
    return FragmentDatagram({.sequence = sequence, .size = 3, .offset = 2, .number = 1, .count = 2},
                            "c");
  };
  for (std::uint32_t sequence = 0; sequence < kMessages; ++sequence) {
    ASSERT_FALSE(Add(kHere, first(sequence)));
    ASSERT_LE(assembly_.partials(), MessageAssembly::kPartialsMax);
    ASSERT_LE(assembly_.open_bytes(), MessageAssembly::kPartialsMax * 3);
  }
  const std::uint32_t oldest = kMessages - MessageAssembly::kPartialsMax;
  EXPECT_EQ(Text(Add(kHere, last(kMessages - 1))), "abc") << "the newest is held";
  EXPECT_EQ(Text(Add(kHere, last(oldest))), "abc") << "as far back as the bound";
  EXPECT_EQ(Text(Add(kHere, last(oldest - 1))), "nothing") << "one more was dropped";
}

TEST_F(MessageAssemblyTest, DropsTheOldestBeyondTheBytesOfAllTogether) {
  const auto bytes = SomeBytes(kLcmMessageBytesMax);
  constexpr std::uint32_t kFit = MessageAssembly::kBytesMax / kLcmMessageBytesMax;
  const auto all_but_last = [&](std::uint32_t sequence) {
    auto datagrams = DatagramsOf(sequence, "CH", bytes);
    const Datagram last = datagrams.back();
    datagrams.pop_back();
    EXPECT_FALSE(AddAll(kHere, datagrams).has_value());
    EXPECT_LE(assembly_.open_bytes(), MessageAssembly::kBytesMax);
    return last;
  };
  std::vector<Datagram> last;
  for (std::uint32_t sequence = 0; sequence <= kFit; ++sequence) {
    last.push_back(all_but_last(sequence));
  }
  EXPECT_EQ(assembly_.open_bytes(), MessageAssembly::kBytesMax);
  EXPECT_EQ(assembly_.partials(), kFit);
  const auto second = Add(kHere, last[1]);
  ASSERT_TRUE(second.has_value());
  EXPECT_EQ(second->bytes, bytes);
  EXPECT_FALSE(Add(kHere, last[0]).has_value()) << "the first was dropped for the newest";
}

TEST_F(MessageAssemblyTest, TakesTheLongestMessageInTheMostFragments) {
  std::optional<LcmMessage> message;
  constexpr std::uint32_t kPieceBytes = kLcmMessageBytesMax / kLcmFragmentsMax;
  const std::string piece(kPieceBytes, 'p');
  for (std::uint32_t i = 0; i < kLcmFragmentsMax; ++i) {
    ASSERT_FALSE(message.has_value());
    message = Add(kHere,
                  Piece(static_cast<std::uint16_t>(i),
                        kLcmFragmentsMax,
                        i * kPieceBytes,
                        piece,
                        kLcmMessageBytesMax));
  }
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(message->bytes.size(), kLcmMessageBytesMax);
}

}  // namespace
}  // namespace faultlab::hardware
