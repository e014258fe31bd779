// The specification against the code: each example of PROTOCOL.md is made and read here, and the
// firmware's framing, compiled for this machine, agrees with the host's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <string>

#include "core/signals/random.h"
#include "hardware/device/frame.h"
#include "hardware/device/messages.h"
#include "tests/support/paths.h"

extern "C" {
#include "firmware/core/frame.h"
}

namespace faultlab::hardware {
namespace {

using testing::HasSubstr;

constexpr std::uint32_t kLines = 1u << 16 | 1u << 19 | 1u << 21 | 1u << 6;

const std::string& Document() {
  static const std::string text = [] {
    std::ifstream in(tests::InSource("hardware/device/PROTOCOL.md"));
    return std::string{(std::istreambuf_iterator<char>(in)), {}};
  }();
  return text;
}

std::string Hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    std::array<char, 4> two{};
    std::snprintf(two.data(), two.size(), "%02x", byte);
    text += (text.empty() ? "" : " ") + std::string(two.data());
  }
  return text;
}

void ExpectExample(const std::string& title, const Frame& frame) {
  const std::string example = title + "\n  body    " + Hex(BodyOf(frame)) + "\n  serial  " +
                              Hex(MakeCobsFraming()->Wrap(frame)) + "\n  TCP     " +
                              Hex(MakeLengthFraming()->Wrap(frame)) + "\n";
  EXPECT_THAT(Document(), HasSubstr(example));
}

Frame Request(DeviceMessage message, std::uint8_t seq, Payload payload = {}) {
  return {.type = static_cast<std::uint8_t>(message), .seq = seq, .payload = std::move(payload)};
}

/// The frame of the example with this title, as its line "serial" has it.
Frame ExampleOf(const std::string& title) {
  const std::size_t at = Document().find("serial  ", Document().find(title));
  std::vector<std::uint8_t> wire;
  for (std::size_t i = at + 8; Document().at(i - 1) != '\n'; i += 3) {
    wire.push_back(static_cast<std::uint8_t>(std::stoi(Document().substr(i, 2), nullptr, 16)));
  }
  std::vector<Frame> frames;
  MakeCobsFraming()->Take(wire, frames);
  return frames.at(0);
}

TEST(ProtocolDocument, HasTheRequestsAsTheCodeMakesThem) {
  ExpectExample("HELLO, version 1, seq 1", Request(DeviceMessage::kHello, 1, HelloPayload()));
  ExpectExample("PLAN, 2000 samples of 10 000 us, delta 9 500 us, seq 2",
                Request(DeviceMessage::kPlan, 2, PlanPayload(2000, 10'000, 9'500)));
  const std::array<std::int16_t, 3> codes{2458, 2458, 1638};
  ExpectExample("DATA, from sample 0: codes 2458, 2458, 1638, seq 3",
                Request(DeviceMessage::kData, 3, DataPayload(0, codes)));
  ExpectExample("ARM, watchdog 250 ms, gap 3 000 us, settling 3 000 us, seq 4",
                Request(DeviceMessage::kArm, 4, ArmPayload(250, 3'000, 3'000)));
  ExpectExample("RELAY, at sample 100: lines Do16, Do19, Do21, Do6 (0x00290040), seq 5",
                Request(DeviceMessage::kRelay, 5, RelayPayload(100, kLines)));
  ExpectExample("START, seq 6", Request(DeviceMessage::kStart, 6));
  ExpectExample("SAFE, seq 7", Request(DeviceMessage::kSafe, 7));
}

TEST(ProtocolDocument, HasAnAckThatTheCodeReads) {
  const Frame frame = ExampleOf("ACK of START");
  EXPECT_EQ(frame.seq, 6);
  const std::optional<DeviceAck> ack = ReadAck(frame.payload);
  ASSERT_TRUE(ack.has_value());
  EXPECT_EQ(ack->request, DeviceMessage::kStart);
  EXPECT_EQ(ack->error, DeviceError::kNone);
  EXPECT_EQ(ack->state, DeviceState::kRun);
  EXPECT_EQ(ack->flags, kRelaysSettled);
  EXPECT_EQ(ack->received, 128u);
  EXPECT_EQ(ack->next, 0u);
  EXPECT_EQ(ack->lines, 0x002a0040u);
}

TEST(ProtocolDocument, HasASampleThatTheCodeReads) {
  const std::optional<DeviceSample> sample = ReadSample(ExampleOf("SAMPLE 100").payload);
  ASSERT_TRUE(sample.has_value());
  EXPECT_EQ(sample->k, 100u);
  EXPECT_EQ(sample->t_us, 1'000'000u);
  EXPECT_EQ(sample->uc, 2458);
  EXPECT_EQ(sample->um, 2195);
  EXPECT_EQ(sample->ua, 2344);
  EXPECT_EQ(sample->ia, 857);
  EXPECT_EQ(sample->count, 40'500);
  EXPECT_EQ(sample->edge_age_us, 12);
  EXPECT_EQ(sample->gate_count, 26);
  EXPECT_EQ(sample->gate_tenth_us, 6245);
  EXPECT_EQ(sample->converted_us, 9512u);
  EXPECT_EQ(sample->lines, kLines);
  EXPECT_EQ(sample->state, DeviceState::kRun);
  EXPECT_EQ(sample->flags, kRelaysSettled);
}

TEST(Crc, IsThatOfTheCheckText) {
  const std::string text = "123456789";
  EXPECT_EQ(Crc16({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}), 0x29b1);
}

Frame RandomFrame(core::Random& random) {
  const auto byte = [&random] { return static_cast<std::uint8_t>(random.Uniform() * 256.0); };
  Frame frame{.type = byte(), .seq = byte(), .payload = {}};
  const auto length = static_cast<std::size_t>(random.Uniform() * (Frame::kPayloadMax + 1));
  for (std::size_t i = 0; i < length; ++i) {
    // Many zeros: they are what COBS is about.
    frame.payload.push_back(random.Uniform() < 0.4 ? std::uint8_t{0} : byte());
  }
  return frame;
}

TEST(FirmwareFrames, AreTheHostsAndTheHostsAreTheFirmwares) {
  core::Random random(3);
  frame_reader reader{};
  const auto framing = MakeCobsFraming();
  for (int i = 0; i < 3000; ++i) {
    const Frame frame = RandomFrame(random);
    const std::vector<std::uint8_t> wire = framing->Wrap(frame);
    std::array<std::uint8_t, FRAME_WIRE_MAX> firmware_wire{};
    const std::uint8_t size = frame_write(firmware_wire.data(),
                                          frame.type,
                                          frame.seq,
                                          frame.payload.data(),
                                          static_cast<std::uint8_t>(frame.payload.size()));
    ASSERT_EQ(Hex(std::span(firmware_wire).first(size)), Hex(wire));
    std::uint8_t length = 0;
    for (const std::uint8_t byte : wire) length = frame_take(&reader, byte);
    ASSERT_EQ(length, frame.payload.size() + 2);
    ASSERT_EQ(Hex({reader.body + 2, frame.payload.size()}), Hex(frame.payload));
  }
  EXPECT_EQ(reader.bad_frames, 0);
}

/// Damage is found, the frame after it is read. One byte that is hit is always seen by a CRC of 16
/// bits; a hit that makes or removes a zero splits or joins frames.
TEST(FirmwareFrames, AreRefusedWithOneByteHitAndTheNextOneIsRead) {
  core::Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const Frame frame = RandomFrame(random);
    std::vector<std::uint8_t> wire = MakeCobsFraming()->Wrap(frame);
    const auto at =
        1 + static_cast<std::size_t>(random.Uniform() * static_cast<double>(wire.size() - 2));
    wire[at] = static_cast<std::uint8_t>(wire[at] ^ 0x10);
    frame_reader reader{};
    int taken = 0;
    for (const std::uint8_t byte : wire) taken += frame_take(&reader, byte) > 0 ? 1 : 0;
    EXPECT_EQ(taken, 0) << Hex(wire);
    std::vector<Frame> frames;
    const auto framing = MakeCobsFraming();
    framing->Take(wire, frames);
    EXPECT_TRUE(frames.empty());
    EXPECT_GT(framing->bad_frames(), 0u);
    EXPECT_GT(reader.bad_frames, 0);
    const std::vector<std::uint8_t> next = framing->Wrap(frame);
    framing->Take(next, frames);
    ASSERT_EQ(frames.size(), 1u);
    for (const std::uint8_t byte : next) taken += frame_take(&reader, byte) > 0 ? 1 : 0;
    EXPECT_EQ(taken, 1);
  }
}

TEST(LengthFrames, EndTheLineWhenALengthIsImpossible) {
  const auto framing = MakeLengthFraming();
  std::vector<Frame> frames;
  const std::array<std::uint8_t, 3> http{'H', 'T', 'T'};
  EXPECT_THROW(framing->Take(http, frames), std::runtime_error);
}

TEST(Messages, OfAnotherVersionHaveTheirVersionAlone) {
  const Payload other{9, 1, 2, 3};
  ASSERT_TRUE(ReadInfo(other).has_value());
  EXPECT_EQ(ReadInfo(other)->version, 9);
  EXPECT_FALSE(ReadInfo(Payload{kDeviceProtocol, 1, 2}).has_value());
  EXPECT_FALSE(ReadAck(Payload(19)).has_value());
  Payload ack(20);
  ack[2] = 4;  // a state that does not exist
  EXPECT_FALSE(ReadAck(ack).has_value());
}

}  // namespace
}  // namespace faultlab::hardware
