#include "hardware/device/device_port.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/types/check.h"
#include "hardware/io_error.h"

namespace faultlab::hardware {
namespace {

using std::chrono::milliseconds;

constexpr Nanoseconds kAnswerIn = milliseconds(40);  ///< much more than a line and a device need
constexpr int kTries = 3;
constexpr Nanoseconds kLook = milliseconds(1);
constexpr Nanoseconds kHelloEvery = milliseconds(100);
/// Samples of a device that nobody asked for any more.
constexpr std::size_t kSamplesMax = 4096;
/// All that a device says in a quarter of a second at 1 kHz, after which it has stopped by itself.
constexpr std::size_t kLookBytesMax = 16 * 1024;
/// So many without a pause are no answer to anything.
constexpr int kFullLooksMax = 8;

const std::string kTcp = "tcp:";
const std::string kSerialServer = "serial-server:";

bool StartsWith(const std::string& text, const std::string& head) {
  return text.compare(0, head.size(), head) == 0;
}

struct HostAndPort {
  std::string host;
  std::string port;
};

/// Of "HOST:PORT"; empty parts when it is not that.
HostAndPort Split(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return {};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

}  // namespace

std::string PortProblem(const std::string& port) {
  for (const std::string& head : {kTcp, kSerialServer}) {
    if (!StartsWith(port, head)) continue;
    const HostAndPort parts = Split(port.substr(head.size()));
    const bool digits =
        !parts.port.empty() && parts.port.size() <= 5 &&
        std::ranges::all_of(parts.port, [](char c) { return c >= '0' && c <= '9'; });
    if (!parts.host.empty() && digits) return {};
    return "must be " + head + "HOST:PORT";
  }
  if (StartsWith(port, "/")) return {};
  return "must be a serial line as /dev/ttyUSB0, tcp:HOST:PORT or serial-server:HOST:PORT";
}

DevicePort::DevicePort(DeviceAddress address, std::shared_ptr<Clock> clock)
    : address_(std::move(address)), clock_(std::move(clock)) {
  LAB_CHECK(PortProblem(address_.port).empty(), address_.port);
}

void DevicePort::Open(Nanoseconds patience) {
  Disconnect();
  const std::string& port = address_.port;
  const auto wait_ms = static_cast<int>(std::chrono::duration_cast<milliseconds>(patience).count());
  if (StartsWith(port, kTcp) || StartsWith(port, kSerialServer)) {
    const bool framed = StartsWith(port, kTcp);
    const HostAndPort to = Split(port.substr((framed ? kTcp : kSerialServer).size()));
    line_ = OpenTcpLine(to.host, to.port, wait_ms);
    framing_ = framed ? MakeLengthFraming() : MakeCobsFraming();
  } else {
    line_ = OpenSerialLine(port, address_.baud);
    framing_ = MakeCobsFraming();
  }
  line_->Flush();
}

void DevicePort::Disconnect() {
  line_.reset();
  samples_.clear();
  answer_.reset();
  info_.reset();
  restart_.reset();
  full_looks_ = 0;
}

DeviceInfo DevicePort::Connect(Nanoseconds patience) {
  Open(patience);
  try {
    const Nanoseconds until = clock_->Now() + patience;
    while (true) {
      seq_ = static_cast<std::uint8_t>(seq_ % 255 + 1);
      Send(DeviceMessage::kHello, seq_, HelloPayload());
      const Nanoseconds again = std::min(until, clock_->Now() + kHelloEvery);
      while (!info_ && clock_->Now() < again) {
        clock_->SleepUntil(clock_->Now() + kLook);
        Poll();
      }
      if (info_ || clock_->Now() >= until) break;
    }
    if (!info_) {
      throw IoError("no device answers at " + address_.port + " (" + std::to_string(bad_frames()) +
                    " unreadable frames): check its power, its cable and [device] baud");
    }
    if (info_->version != kDeviceProtocol) {
      throw IoError("the device at " + address_.port + " speaks version " +
                    std::to_string(info_->version) + " of the protocol, this program version " +
                    std::to_string(kDeviceProtocol) + ": flash the firmware of this release");
    }
  } catch (const IoError&) {
    Disconnect();
    throw;
  }
  // What it said before it was asked is of an earlier conversation.
  samples_.clear();
  restart_.reset();
  heard_at_ = clock_->Now();
  return *info_;
}

void DevicePort::Send(DeviceMessage message, std::uint8_t seq, const Payload& payload) {
  if (line_ == nullptr) throw IoError("the line to the device is closed");
  line_->Write(
      framing_->Wrap({.type = static_cast<std::uint8_t>(message), .seq = seq, .payload = payload}));
  asked_at_ = clock_->Now();
}

DeviceAck DevicePort::AskFor(DeviceMessage message, const Payload& payload) {
  seq_ = static_cast<std::uint8_t>(seq_ % 255 + 1);
  answer_.reset();
  for (int attempt = 0; attempt < kTries; ++attempt) {
    Send(message, seq_, payload);
    const Nanoseconds until = clock_->Now() + kAnswerIn;
    while (clock_->Now() < until) {
      clock_->SleepUntil(clock_->Now() + kLook);
      Poll();
      if (answer_ && answer_->request == message) return *answer_;
    }
  }
  throw IoError("the device does not answer " + std::string(NameOf(message)));
}

DeviceAck DevicePort::Ask(DeviceMessage message, const Payload& payload) {
  const DeviceAck answer = AskFor(message, payload);
  if (answer.error != DeviceError::kNone) {
    throw IoError("the device refuses " + std::string(NameOf(message)) + ": " +
                  std::string(TextOf(answer.error)));
  }
  return answer;
}

void DevicePort::Poll() {
  if (line_ == nullptr) throw IoError("the line to the device is closed");
  std::array<std::uint8_t, 512> bytes{};
  std::vector<Frame> frames;
  std::size_t taken = 0;
  while (taken < kLookBytesMax) {
    const std::size_t size = line_->Read(bytes);
    if (size == 0) break;
    framing_->Take(std::span(bytes).first(size), frames);
    taken += size;
  }
  for (const Frame& frame : frames) Sort(frame);
  full_looks_ = taken < kLookBytesMax ? 0 : full_looks_ + 1;
  if (full_looks_ < kFullLooksMax) return;
  throw IoError("the device at " + address_.port + " floods its line, more than " +
                std::to_string(kFullLooksMax * kLookBytesMax / 1024) +
                " kB without a pause: it does not run the firmware of this bench");
}

void DevicePort::Sort(const Frame& frame) {
  switch (static_cast<DeviceMessage>(frame.type)) {
    case DeviceMessage::kInfo:
      if (auto info = ReadInfo(frame.payload)) {
        (frame.seq == 0 ? restart_ : info_) = info;
        heard_at_ = clock_->Now();
      }
      return;
    case DeviceMessage::kAck:
      if (auto ack = ReadAck(frame.payload)) {
        status_ = *ack;
        if (frame.seq == seq_) answer_ = ack;
        heard_at_ = clock_->Now();
      }
      return;
    case DeviceMessage::kSample:
      if (auto sample = ReadSample(frame.payload)) {
        if (samples_.size() < kSamplesMax) samples_.push_back(*sample);
        heard_at_ = clock_->Now();
      }
      return;
    default:
      return;
  }
}

std::deque<DeviceSample> DevicePort::TakeSamples() {
  return std::exchange(samples_, {});
}

std::optional<DeviceInfo> DevicePort::TakeRestart() {
  return std::exchange(restart_, std::nullopt);
}

}  // namespace faultlab::hardware
