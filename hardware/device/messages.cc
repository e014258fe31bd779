#include "hardware/device/messages.h"

#include <concepts>
#include <type_traits>

#include "core/types/check.h"

namespace faultlab::hardware {
namespace {

constexpr std::size_t kInfoLength = 64;
constexpr std::size_t kAckLength = 20;
constexpr std::size_t kSampleLength = 36;

template <std::integral T>
void Put(Payload& payload, T value) {
  auto rest = static_cast<std::make_unsigned_t<T>>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    payload.push_back(static_cast<std::uint8_t>(rest & 0xffu));
    if constexpr (sizeof(T) > 1) rest = static_cast<std::make_unsigned_t<T>>(rest >> 8);
  }
}

/// Little-endian fields, in order. Contract: the payload is long enough.
class Fields {
 public:
  explicit Fields(std::span<const std::uint8_t> payload) : payload_(payload) {}

  template <std::integral T>
  void operator()(T& value) {
    std::uint64_t read = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      read |= static_cast<std::uint64_t>(payload_[at_++]) << (8 * i);
    }
    value = static_cast<T>(read);
  }
  /// @returns false above the last value of the enumeration.
  template <typename E>
  requires std::is_enum_v<E>
  bool operator()(E& value, E last) {
    std::underlying_type_t<E> read{};
    (*this)(read);
    value = static_cast<E>(read);
    return value <= last;
  }

 private:
  std::span<const std::uint8_t> payload_;
  std::size_t at_ = 0;
};

void Read(Fields& read, DeviceChannel& channel) {
  read(channel.step_nv);
  read(channel.offset);
  read(channel.bits);
}

}  // namespace

std::string_view TextOf(DeviceFault fault) {
  switch (fault) {
    case DeviceFault::kNone:
      return "no fault";
    case DeviceFault::kCommunication:
      return "it heard nothing from this side in time (its watchdog)";
    case DeviceFault::kUnderrun:
      return "the values of the plan did not reach it in time";
    case DeviceFault::kRelay:
      return "its relay lines read back otherwise than it wrote them";
    case DeviceFault::kTiming:
      return "it could not finish a sample within its period";
  }
  return "unknown fault";
}

std::string_view TextOf(DeviceError error) {
  switch (error) {
    case DeviceError::kNone:
      return "done";
    case DeviceError::kLength:
      return "the payload has another length";
    case DeviceError::kType:
      return "it does not know this message";
    case DeviceError::kState:
      return "not in this state";
    case DeviceError::kRange:
      return "a value is outside what it can do";
    case DeviceError::kOffset:
      return "not in order";
    case DeviceError::kFull:
      return "its buffer is full";
    case DeviceError::kLate:
      return "that sample has begun already";
    case DeviceError::kVersion:
      return "it speaks another version of the protocol";
  }
  return "unknown error";
}

std::string_view NameOf(DeviceMessage message) {
  switch (message) {
    case DeviceMessage::kHello:
      return "HELLO";
    case DeviceMessage::kPlan:
      return "PLAN";
    case DeviceMessage::kData:
      return "DATA";
    case DeviceMessage::kArm:
      return "ARM";
    case DeviceMessage::kStart:
      return "START";
    case DeviceMessage::kHeartbeat:
      return "HEARTBEAT";
    case DeviceMessage::kSafe:
      return "SAFE";
    case DeviceMessage::kRelay:
      return "RELAY";
    case DeviceMessage::kClear:
      return "CLEAR";
    case DeviceMessage::kResend:
      return "RESEND";
    case DeviceMessage::kInfo:
      return "INFO";
    case DeviceMessage::kAck:
      return "ACK";
    case DeviceMessage::kSample:
      return "SAMPLE";
  }
  return "?";
}

std::string_view ResetCauseText(std::uint8_t cause) {
  switch (cause) {
    case 1:
      return "power-up";
    case 2:
      return "its reset pin";
    case 3:
      return "a brown-out of its supply";
    case 4:
      return "its own watchdog";
    default:
      return "an unknown cause";
  }
}

Payload HelloPayload() {
  return {kDeviceProtocol};
}

Payload PlanPayload(std::uint32_t samples, std::uint32_t period_us, std::uint32_t delta_us) {
  Payload payload;
  Put(payload, samples);
  Put(payload, period_us);
  Put(payload, delta_us);
  return payload;
}

Payload DataPayload(std::uint32_t first, std::span<const std::int16_t> codes) {
  LAB_CHECK(!codes.empty() && codes.size() <= kDataValuesMax, codes.size());
  Payload payload;
  Put(payload, first);
  for (const std::int16_t code : codes) Put(payload, code);
  return payload;
}

Payload ArmPayload(std::uint16_t watchdog_ms, std::uint16_t gap_us, std::uint16_t settle_us) {
  Payload payload;
  Put(payload, watchdog_ms);
  Put(payload, gap_us);
  Put(payload, settle_us);
  return payload;
}

Payload RelayPayload(std::uint32_t at, std::uint32_t lines) {
  Payload payload;
  Put(payload, at);
  Put(payload, lines);
  return payload;
}

Payload ResendPayload(std::uint32_t k) {
  Payload payload;
  Put(payload, k);
  return payload;
}

std::optional<DeviceInfo> ReadInfo(std::span<const std::uint8_t> payload) {
  DeviceInfo info;
  if (!payload.empty() && payload[0] != kDeviceProtocol) {
    info.version = payload[0];
    return info;
  }
  if (payload.size() != kInfoLength) return std::nullopt;
  Fields read(payload);
  read(info.version);
  read(info.firmware);
  read(info.reset_cause);
  read(info.capabilities);
  if (!read(info.state, DeviceState::kFault)) return std::nullopt;
  if (!read(info.fault, DeviceFault::kTiming)) return std::nullopt;
  read(info.period_min_us);
  read(info.period_max_us);
  read(info.convert_us);
  read(info.plan_values);
  read(info.relay_entries);
  read(info.uc.step_nv);
  read(info.uc.offset);
  read(info.uc_min);
  read(info.uc_max);
  Read(read, info.um);
  Read(read, info.ua);
  Read(read, info.ia);
  read(info.relay_lines);
  read(info.safe_lines);
  read(info.make_first_lines);
  return info;
}

std::optional<DeviceAck> ReadAck(std::span<const std::uint8_t> payload) {
  if (payload.size() != kAckLength) return std::nullopt;
  Fields read(payload);
  DeviceAck ack;
  if (!read(ack.request, DeviceMessage::kSample)) return std::nullopt;
  if (!read(ack.error, DeviceError::kVersion)) return std::nullopt;
  if (!read(ack.state, DeviceState::kFault)) return std::nullopt;
  if (!read(ack.fault, DeviceFault::kTiming)) return std::nullopt;
  read(ack.flags);
  read(ack.bad_frames);
  read(ack.received);
  read(ack.next);
  read(ack.lines);
  read(ack.drops);
  return ack;
}

std::optional<DeviceSample> ReadSample(std::span<const std::uint8_t> payload) {
  if (payload.size() != kSampleLength) return std::nullopt;
  Fields read(payload);
  DeviceSample sample;
  read(sample.k);
  read(sample.t_us);
  read(sample.uc);
  read(sample.um);
  read(sample.ua);
  read(sample.ia);
  read(sample.count);
  read(sample.edge_age_us);
  read(sample.gate_count);
  read(sample.gate_tenth_us);
  read(sample.converted_us);
  read(sample.lines);
  if (!read(sample.state, DeviceState::kFault)) return std::nullopt;
  read(sample.flags);
  return sample;
}

}  // namespace faultlab::hardware
