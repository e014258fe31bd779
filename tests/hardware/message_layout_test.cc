// No length in a message is trusted: every type, every place of a length.
#include "hardware/lcm/message_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "hardware/lcm/channels.h"
#include "hardware/lcm/message_codec.h"
#include "hardware/lcm/rig_codec.h"
#include "hardware/lcm/rig_name.h"
#include "tests/hardware/wire_message.h"
#include "tests/support/paths.h"

namespace faultlab::hardware {
namespace {

template <typename List>
struct AsTypes;
template <typename... Messages>
struct AsTypes<MessageList<Messages...>> {
  using Types = testing::Types<Messages...>;
  static std::set<std::string> Names() { return {Messages::getTypeName()...}; }
};

template <typename Message>
class EveryMessage : public testing::Test {
 protected:
  WireMessage Next() { return MakeWireMessage<Message>(random_); }
  core::Random random_{11};
};
TYPED_TEST_SUITE(EveryMessage, AsTypes<AllMessages>::Types);

TYPED_TEST(EveryMessage, IsWalkedAndDecodedToTheSameSizeAndBytes) {
  for (int i = 0; i < 300; ++i) {
    const WireMessage wire = this->Next();
    const auto body = std::span(wire.bytes).subspan(kMessageHashBytes);
    ASSERT_EQ(WalkMessage(LayoutOf<TypeParam>::kMessage, body), body.size());
    const auto message = FromBytes<TypeParam>(wire.bytes);
    ASSERT_TRUE(message.has_value());
    ASSERT_EQ(ToBytes(*message), wire.bytes);
  }
}

TYPED_TEST(EveryMessage, IsRefusedWithABadLengthAtAnyPlace) {
  for (int i = 0; i < 20; ++i) {
    const WireMessage wire = this->Next();
    std::vector<std::size_t> places = wire.strings;
    places.insert(places.end(), wire.counts.begin(), wire.counts.end());
    for (const std::size_t at : places) {
      const auto left = static_cast<std::int32_t>(wire.bytes.size() - at - 4);
      std::vector<std::int32_t> lengths(std::begin(kBadLengths), std::end(kBadLengths));
      lengths.insert(lengths.end(), {left + 1, left + 2});
      for (const std::int32_t length : lengths) {
        std::vector<std::uint8_t> bytes = wire.bytes;
        PutInt(bytes, at, length);
        ASSERT_FALSE(FromBytes<TypeParam>(bytes).has_value()) << length << " at " << at;
      }
    }
    for (const std::size_t at : wire.strings) {
      std::vector<std::uint8_t> bytes = wire.bytes;
      PutInt(bytes, at, 0);
      ASSERT_FALSE(FromBytes<TypeParam>(bytes).has_value()) << "a string without its NUL at " << at;
    }
  }
}

TYPED_TEST(EveryMessage, IsRefusedWhenAStringIsNotEndedByItsOnlyNul) {
  int strings = 0;
  for (int i = 0; i < 20; ++i) {
    const WireMessage wire = this->Next();
    for (const std::size_t at : wire.strings) {
      ++strings;
      const std::size_t last = at + 3 + static_cast<std::size_t>(wire.bytes[at + 3]);
      std::vector<std::uint8_t> bytes = wire.bytes;
      bytes[last] = 'x';
      ASSERT_FALSE(FromBytes<TypeParam>(bytes).has_value()) << at;
      bytes = wire.bytes;
      if (last == at + 4) continue;  // an empty string
      bytes[at + 4] = 0;
      ASSERT_FALSE(FromBytes<TypeParam>(bytes).has_value()) << at;
    }
  }
  const bool has_strings = std::any_of(
      LayoutOf<TypeParam>::kFields,
      std::end(LayoutOf<TypeParam>::kFields),
      [](const FieldLayout& field) { return field.bytes == 0 && field.message == nullptr; });
  EXPECT_EQ(strings > 0, has_strings);
}

TYPED_TEST(EveryMessage, IsRefusedWhenItIsCutAtAnyByteOrTooLong) {
  for (int i = 0; i < 5; ++i) {
    const WireMessage wire = this->Next();
    for (std::size_t size = 0; size < wire.bytes.size(); ++size) {
      // Its own buffer, so that the sanitizer detects a read past its end.
      const std::vector<std::uint8_t> cut(wire.bytes.begin(),
                                          wire.bytes.begin() + static_cast<std::ptrdiff_t>(size));
      ASSERT_FALSE(FromBytes<TypeParam>(cut).has_value()) << size;
    }
    std::vector<std::uint8_t> longer = wire.bytes;
    longer.push_back(0);
    ASSERT_FALSE(FromBytes<TypeParam>(longer).has_value());
  }
}

TYPED_TEST(EveryMessage, SurvivesRandomChangesAndWhatPassesIsWhole) {
  constexpr int kTries = 10'000;  // 120 000 over the twelve types
  int passed = 0;
  for (int i = 0; i < kTries; ++i) {
    WireMessage wire = this->Next();
    std::vector<std::uint8_t>& bytes = wire.bytes;
    std::vector<std::size_t> places = wire.strings;
    places.insert(places.end(), wire.counts.begin(), wire.counts.end());
    for (std::uint64_t n = 1 + this->random_.Below(3); n > 0; --n) {
      const std::size_t at =
          kMessageHashBytes + this->random_.Below(bytes.size() - kMessageHashBytes);
      switch (this->random_.Below(places.empty() ? 2 : 4)) {
        case 0:
          bytes[at] ^= static_cast<std::uint8_t>(1u << this->random_.Below(8));
          break;
        case 1:
          bytes[at] = static_cast<std::uint8_t>(this->random_.Below(256));
          break;
        case 2:  // any length
          PutInt(bytes,
                 places[this->random_.Below(places.size())],
                 static_cast<std::int32_t>(this->random_.Below(1ull << 32)));
          break;
        default:  // a length near the right one
          PutInt(bytes,
                 places[this->random_.Below(places.size())],
                 static_cast<std::int32_t>(this->random_.Below(40)) - 4);
      }
    }
    if (this->random_.Below(8) == 0) bytes.resize(this->random_.Below(bytes.size()));
    if (const auto message = FromBytes<TypeParam>(bytes)) {
      ++passed;
      ASSERT_EQ(ToBytes(*message), bytes);
    }
  }
  EXPECT_GT(passed, 0);
  EXPECT_LT(passed, kTries);
}

TEST(MessageLayouts, AreThereForEveryTypeOfTheFolder) {
  std::set<std::string> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(tests::InSource("hardware/lcm/types"))) {
    files.insert(entry.path().stem().string());
  }
  EXPECT_EQ(AsTypes<AllMessages>::Names(), files);
}

TEST(MessageLayouts, AreWalkedBeforeEveryDecode) {
  // LCM's decoders and their callers: typed subscriptions and liblcm's reader of logs.
  const std::vector<std::string> calls = {
      ".decode(", "->decode(", "_decodeNoHash(", "readNextEvent(", ".subscribe(", "->subscribe("};
  std::set<std::string> callers;
  int files = 0;
  for (const std::string folder : {"hardware", "server"}) {
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(tests::InSource(folder))) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cc") continue;
      ++files;
      std::ifstream in(entry.path());
      const std::string text((std::istreambuf_iterator<char>(in)), {});
      for (const std::string& call : calls) {
        if (text.find(call) != std::string::npos) {
          callers.insert(entry.path().filename().string() + " " + call);
        }
      }
    }
  }
  EXPECT_GT(files, 100);
  EXPECT_EQ(callers, std::set<std::string>{"message_codec.h .decode("});
}

TEST(ShownText, IsUtf8AndCutBetweenCharacters) {
  EXPECT_EQ(ShownText("R\xe9sistance"), "(not UTF-8)");
  EXPECT_EQ(ShownText("am\u00e9", 4), "am\u00e9");
  EXPECT_EQ(ShownText("am\u00e9", 3), "am");
  EXPECT_EQ(ShownText("\U0001F600", 3), "");
}

}  // namespace
}  // namespace faultlab::hardware
