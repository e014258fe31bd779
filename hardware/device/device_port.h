#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "hardware/clock.h"
#include "hardware/device/byte_stream.h"
#include "hardware/device/frame.h"
#include "hardware/device/messages.h"

namespace faultlab::hardware {

/// Where a device is: "/dev/ttyUSB0" (serial), "tcp:HOST:PORT" (frames with their length) or
/// "serial-server:HOST:PORT" (a serial line behind a network adapter).
struct DeviceAddress {
  std::string port;
  int baud = 250'000;
};
/// Empty, or what is wrong with the port's text.
std::string PortProblem(const std::string& port);

/// The conversation with one device: one request at a time, repeated when no answer comes; samples
/// are collected. All waits are the clock's. Not thread-safe.
class DevicePort {
 public:
  DevicePort(DeviceAddress address, std::shared_ptr<Clock> clock);

  /// Opens the line, forgets what was on it, and asks who is there until `patience` has passed.
  /// Throws IoError.
  DeviceInfo Connect(Nanoseconds patience);
  bool connected() const { return line_ != nullptr; }
  void Disconnect();

  /// Sends, waits for the answer; repeats twice. Throws IoError when there is none or when the
  /// device refuses; AskFor gives the refusal back.
  DeviceAck Ask(DeviceMessage message, const Payload& payload = {});
  DeviceAck AskFor(DeviceMessage message, const Payload& payload = {});
  /// Takes what has come, and of a device that floods its line only so much that the interlocks do
  /// not wait for it. Throws IoError when the line is gone, or when the flood goes on.
  void Poll();

  /// Samples that have come, in the order of their arrival.
  std::deque<DeviceSample> TakeSamples();
  /// The device has said who it is without being asked: it has started anew.
  std::optional<DeviceInfo> TakeRestart();
  /// The newest answer of the device to anything.
  const DeviceAck& status() const { return status_; }
  Nanoseconds heard_at() const { return heard_at_; }
  Nanoseconds asked_at() const { return asked_at_; }
  /// What was read as a frame and was none, since the line was opened.
  std::uint64_t bad_frames() const { return framing_->bad_frames(); }

 private:
  void Open(Nanoseconds patience);
  void Send(DeviceMessage message, std::uint8_t seq, const Payload& payload);
  void Sort(const Frame& frame);

  const DeviceAddress address_;
  const std::shared_ptr<Clock> clock_;
  std::unique_ptr<ByteStream> line_;
  std::unique_ptr<Framing> framing_;
  std::uint8_t seq_ = 0;  ///< of the request that waits; 0 is the device's own
  std::optional<DeviceAck> answer_;
  std::optional<DeviceInfo> info_;
  std::optional<DeviceInfo> restart_;
  DeviceAck status_;
  std::deque<DeviceSample> samples_;
  int full_looks_ = 0;  ///< one after the other
  Nanoseconds heard_at_{0};
  Nanoseconds asked_at_{0};
};

}  // namespace faultlab::hardware
