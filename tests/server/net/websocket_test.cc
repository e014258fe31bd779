#include "server/net/websocket.h"

#include <gtest/gtest.h>

#include "tests/support/raw_client.h"

namespace faultlab::server::websocket {
namespace {

using tests::ClientFrame;

constexpr std::size_t kMax = 1000;

TEST(AcceptKey, IsTheOneOfRfc6455) {
  EXPECT_EQ(AcceptKey("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
}

TEST(AcceptKey, TakesOnlySixteenBytesInBase64) {
  EXPECT_TRUE(IsValidKey("dGhlIHNhbXBsZSBub25jZQ=="));
  EXPECT_FALSE(IsValidKey("dGhlIHNhbXBsZSBub25jZQ="));
  EXPECT_FALSE(IsValidKey("dGhlIHNhbXBsZSBub2$jZQ=="));
  EXPECT_FALSE(IsValidKey(""));
}

TEST(EncodeFrame, ChoosesTheShortestLength) {
  EXPECT_EQ(EncodeFrame(Opcode::kText, "hi"), "\x81\x02hi");
  const std::string medium = EncodeFrame(Opcode::kBinary, std::string(300, 'x'));
  EXPECT_EQ(medium.substr(0, 4), std::string("\x82\x7e\x01\x2c", 4));
  const std::string large = EncodeFrame(Opcode::kBinary, std::string(70'000, 'x'));
  EXPECT_EQ(large.substr(0, 10), std::string("\x82\x7f\0\0\0\0\0\x01\x11\x70", 10));
}

TEST(EncodeClose, CarriesCodeAndReason) {
  EXPECT_EQ(EncodeClose(CloseCode::kTooBig, "long"), std::string("\x88\x06\x03\xf1long"));
}

TEST(FrameReader, ReadsMessagesHoweverTheyAreCut) {
  const std::string bytes = ClientFrame(0x81, "first") + ClientFrame(0x82, std::string(200, 'y')) +
                            ClientFrame(0x89, "ping");
  for (std::size_t step = 1; step <= bytes.size(); step += 3) {
    FrameReader reader(kMax);
    std::vector<FrameReader::Message> messages;
    for (std::size_t at = 0; at < bytes.size(); at += step) {
      reader.Append(std::string_view(bytes).substr(at, step));
      while (auto message = reader.Next()) messages.push_back(std::move(*message));
    }
    ASSERT_EQ(messages.size(), 3u) << step;
    EXPECT_EQ(messages[0].payload, "first");
    EXPECT_EQ(messages[1].opcode, Opcode::kBinary);
    EXPECT_EQ(messages[1].payload, std::string(200, 'y'));
    EXPECT_EQ(messages[2].opcode, Opcode::kPing);
  }
}

TEST(FrameReader, JoinsFragmentsWithAPingBetween) {
  FrameReader reader(kMax);
  reader.Append(ClientFrame(0x01, "one ") + ClientFrame(0x89, "") + ClientFrame(0x00, "two ") +
                ClientFrame(0x80, "three"));
  EXPECT_EQ(reader.Next()->opcode, Opcode::kPing);
  const auto whole = reader.Next();
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->opcode, Opcode::kText);
  EXPECT_EQ(whole->payload, "one two three");
  EXPECT_FALSE(reader.Next());
}

struct Broken {
  const char* what;
  std::string bytes;
  CloseCode code;
};

TEST(FrameReader, RefusesBrokenFrames) {
  const Broken cases[] = {
      {"unmasked", ClientFrame(0x81, "x", false), CloseCode::kProtocolError},
      {"reserved bit", ClientFrame(0xC1, "x"), CloseCode::kProtocolError},
      {"unknown opcode", ClientFrame(0x83, "x"), CloseCode::kProtocolError},
      {"fragmented ping", ClientFrame(0x09, "x"), CloseCode::kProtocolError},
      {"long ping", ClientFrame(0x89, std::string(126, 'x')), CloseCode::kProtocolError},
      {"lonely continuation", ClientFrame(0x80, "x"), CloseCode::kProtocolError},
      {"new text inside fragments",
       ClientFrame(0x01, "x") + ClientFrame(0x81, "y"),
       CloseCode::kProtocolError},
      {"too big", ClientFrame(0x81, std::string(kMax + 1, 'x')), CloseCode::kTooBig},
      {"fragments too big together",
       ClientFrame(0x01, std::string(600, 'x')) + ClientFrame(0x80, std::string(600, 'x')),
       CloseCode::kTooBig},
  };
  for (const Broken& broken : cases) {
    FrameReader reader(kMax);
    reader.Append(broken.bytes);
    while (reader.Next()) {
    }
    ASSERT_TRUE(reader.error()) << broken.what;
    EXPECT_EQ(*reader.error(), broken.code) << broken.what;
    reader.Append(ClientFrame(0x81, "later"));
    EXPECT_FALSE(reader.Next()) << broken.what;
  }
}

TEST(FrameReader, JudgesAHugeLengthBeforeItArrives) {
  FrameReader reader(kMax);
  reader.Append(std::string("\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff", 10));
  EXPECT_FALSE(reader.Next());
  EXPECT_EQ(reader.error(), CloseCode::kTooBig);
}

}  // namespace
}  // namespace faultlab::server::websocket
