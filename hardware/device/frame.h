#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace faultlab::hardware {

/// CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xffff, not reflected. 0x29b1 of "123456789".
std::uint16_t Crc16(std::span<const std::uint8_t> bytes);

/// One message of the device protocol (PROTOCOL.md).
struct Frame {
  static constexpr std::size_t kPayloadMax = 64;

  std::uint8_t type = 0;
  std::uint8_t seq = 0;
  std::vector<std::uint8_t> payload;
};

/// type, seq, payload, CRC.
std::vector<std::uint8_t> BodyOf(const Frame& frame);

/// Frames in a stream of bytes. A frame that is not whole is counted and left out; the next whole
/// one is found again.
class Framing {
 public:
  virtual ~Framing() = default;

  virtual std::vector<std::uint8_t> Wrap(const Frame& frame) const = 0;
  /// Takes what has come and appends the frames that it completes.
  virtual void Take(std::span<const std::uint8_t> bytes, std::vector<Frame>& out) = 0;
  /// Forgets a frame that has begun.
  virtual void Restart() = 0;
  std::uint64_t bad_frames() const { return bad_frames_; }

 protected:
  static constexpr std::size_t kBodyMax = Frame::kPayloadMax + 4;

  /// Appends the frame of the body, or counts it as bad.
  void Accept(std::span<const std::uint8_t> body, std::vector<Frame>& out);
  void CountBad() { ++bad_frames_; }

 private:
  std::uint64_t bad_frames_ = 0;
};

/// 0x00 COBS(body) 0x00: serial lines. Resynchronises at the next 0x00.
std::unique_ptr<Framing> MakeCobsFraming();
/// Length of the body (2 bytes, little-endian), body: TCP, which loses nothing. A length that no
/// body has throws IoError, since nothing tells where the next frame begins.
std::unique_ptr<Framing> MakeLengthFraming();

}  // namespace faultlab::hardware
