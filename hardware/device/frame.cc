#include "hardware/device/frame.h"

#include <string>

#include "core/types/check.h"
#include "hardware/io_error.h"

namespace faultlab::hardware {
namespace {

constexpr std::size_t kBodyMin = 4;

class CobsFraming final : public Framing {
 public:
  std::vector<std::uint8_t> Wrap(const Frame& frame) const override {
    std::vector<std::uint8_t> wire{0, 0};
    std::size_t code_at = 1;
    const auto close_block = [&] {
      wire[code_at] = static_cast<std::uint8_t>(wire.size() - code_at);
    };
    for (const std::uint8_t byte : BodyOf(frame)) {
      if (byte != 0) {
        wire.push_back(byte);
        continue;
      }
      close_block();
      code_at = wire.size();
      wire.push_back(0);
    }
    close_block();
    wire.push_back(0);
    return wire;
  }

  void Take(std::span<const std::uint8_t> bytes, std::vector<Frame>& out) override {
    for (const std::uint8_t byte : bytes) {
      if (byte == 0) {
        if (!coded_.empty()) Decode(out);
        coded_.clear();
      } else if (coded_.size() <= kBodyMax + 1) {
        coded_.push_back(byte);
      }
    }
  }

  void Restart() override { coded_.clear(); }

 private:
  void Decode(std::vector<Frame>& out) {
    std::vector<std::uint8_t> body;
    for (std::size_t at = 0; at < coded_.size();) {
      const std::size_t end = at + coded_[at];
      if (end > coded_.size()) {
        CountBad();
        return;
      }
      body.insert(body.end(),
                  coded_.begin() + static_cast<std::ptrdiff_t>(at) + 1,
                  coded_.begin() + static_cast<std::ptrdiff_t>(end));
      at = end;
      if (at < coded_.size()) body.push_back(0);
    }
    Accept(body, out);
  }

  std::vector<std::uint8_t> coded_;
};

class LengthFraming final : public Framing {
 public:
  std::vector<std::uint8_t> Wrap(const Frame& frame) const override {
    const std::vector<std::uint8_t> body = BodyOf(frame);
    std::vector<std::uint8_t> wire{static_cast<std::uint8_t>(body.size()), 0};
    wire.insert(wire.end(), body.begin(), body.end());
    return wire;
  }

  void Take(std::span<const std::uint8_t> bytes, std::vector<Frame>& out) override {
    for (const std::uint8_t byte : bytes) {
      held_.push_back(byte);
      if (held_.size() < 2) continue;
      const std::size_t length = held_[0] + 256u * held_[1];
      if (length < kBodyMin || length > kBodyMax) {
        held_.clear();
        throw IoError("the device sends a frame of " + std::to_string(length) +
                      " bytes: it does not speak this protocol over TCP");
      }
      if (held_.size() < length + 2) continue;
      Accept(std::span(held_).subspan(2), out);
      held_.clear();
    }
  }

  void Restart() override { held_.clear(); }

 private:
  std::vector<std::uint8_t> held_;
};

}  // namespace

std::uint16_t Crc16(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xffff;
  for (const std::uint8_t byte : bytes) {
    crc ^= static_cast<unsigned>(byte) << 8;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 0x8000u) != 0 ? (crc << 1) ^ 0x1021u : crc << 1;
    }
    crc &= 0xffffu;
  }
  return static_cast<std::uint16_t>(crc);
}

std::vector<std::uint8_t> BodyOf(const Frame& frame) {
  LAB_CHECK(frame.payload.size() <= Frame::kPayloadMax, frame.payload.size());
  std::vector<std::uint8_t> body{frame.type, frame.seq};
  body.insert(body.end(), frame.payload.begin(), frame.payload.end());
  const std::uint16_t crc = Crc16(body);
  body.push_back(static_cast<std::uint8_t>(crc >> 8));
  body.push_back(static_cast<std::uint8_t>(crc & 0xff));
  return body;
}

void Framing::Accept(std::span<const std::uint8_t> body, std::vector<Frame>& out) {
  if (body.size() < kBodyMin || body.size() > kBodyMax || Crc16(body) != 0) {
    CountBad();
    return;
  }
  const auto payload = body.subspan(2, body.size() - kBodyMin);
  out.push_back({.type = body[0], .seq = body[1], .payload = {payload.begin(), payload.end()}});
}

std::unique_ptr<Framing> MakeCobsFraming() {
  return std::make_unique<CobsFraming>();
}

std::unique_ptr<Framing> MakeLengthFraming() {
  return std::make_unique<LengthFraming>();
}

}  // namespace faultlab::hardware
