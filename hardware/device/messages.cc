#include "hardware/device/messages.h"

#include <array>
#include <concepts>
#include <type_traits>
#include <utility>

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

template <std::integral... T>
Payload Packed(T... values) {
  Payload payload;
  (Put(payload, values), ...);
  return payload;
}

/// Little-endian fields, in order. Contract: the payload is long enough.
class Fields {
 public:
  explicit Fields(std::span<const std::uint8_t> payload) : payload_(payload) {}

  template <std::integral... T>
  void operator()(T&... values) {
    (Read(values), ...);
  }
  /// @returns false above the last value of the enumeration.
  template <typename E>
  requires std::is_enum_v<E>
  bool operator()(E& value, E last) {
    std::underlying_type_t<E> read{};
    Read(read);
    value = static_cast<E>(read);
    return value <= last;
  }

 private:
  template <std::integral T>
  void Read(T& value) {
    std::uint64_t read = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      read |= static_cast<std::uint64_t>(payload_[at_++]) << (8 * i);
    }
    value = static_cast<T>(read);
  }

  std::span<const std::uint8_t> payload_;
  std::size_t at_ = 0;
};

}  // namespace

std::string_view TextOf(DeviceFault fault) {
  constexpr std::array<std::string_view, 5> kTexts = {
      "no fault",
      "it heard nothing from this side in time (its watchdog)",
      "the values of the plan did not reach it in time",
      "its relay lines read back otherwise than it wrote them",
      "it could not finish a sample within its period"};
  return kTexts[static_cast<std::size_t>(fault)];
}

std::string_view TextOf(DeviceError error) {
  constexpr std::array<std::string_view, 9> kTexts = {"done",
                                                      "the payload has another length",
                                                      "it does not know this message",
                                                      "not in this state",
                                                      "a value is outside what it can do",
                                                      "not in order",
                                                      "its buffer is full",
                                                      "that sample has begun already",
                                                      "it speaks another version of the protocol"};
  return kTexts[static_cast<std::size_t>(error)];
}

std::string_view NameOf(DeviceMessage message) {
  using enum DeviceMessage;
  constexpr std::array<std::pair<DeviceMessage, std::string_view>, 13> kNames = {{
      {kHello, "HELLO"},
      {kPlan, "PLAN"},
      {kData, "DATA"},
      {kArm, "ARM"},
      {kStart, "START"},
      {kHeartbeat, "HEARTBEAT"},
      {kSafe, "SAFE"},
      {kRelay, "RELAY"},
      {kClear, "CLEAR"},
      {kResend, "RESEND"},
      {kInfo, "INFO"},
      {kAck, "ACK"},
      {kSample, "SAMPLE"},
  }};
  for (const auto& [each, name] : kNames) {
    if (each == message) return name;
  }
  return "?";
}

std::string_view ResetCauseText(std::uint8_t cause) {
  constexpr std::array<std::string_view, 5> kCauses = {"an unknown cause",
                                                       "power-up",
                                                       "its reset pin",
                                                       "a brown-out of its supply",
                                                       "its own watchdog"};
  return kCauses[cause < kCauses.size() ? std::size_t{cause} : 0];
}

Payload HelloPayload() {
  return {kDeviceProtocol};
}

Payload PlanPayload(std::uint32_t samples, std::uint32_t period_us, std::uint32_t delta_us) {
  return Packed(samples, period_us, delta_us);
}

Payload DataPayload(std::uint32_t first, std::span<const std::int16_t> codes) {
  LAB_CHECK(!codes.empty() && codes.size() <= kDataValuesMax, codes.size());
  Payload payload = Packed(first);
  for (const std::int16_t code : codes) Put(payload, code);
  return payload;
}

Payload ArmPayload(std::uint16_t watchdog_ms, std::uint16_t gap_us, std::uint16_t settle_us) {
  return Packed(watchdog_ms, gap_us, settle_us);
}

Payload RelayPayload(std::uint32_t at, std::uint32_t lines) {
  return Packed(at, lines);
}

Payload ResendPayload(std::uint32_t k) {
  return Packed(k);
}

std::optional<DeviceInfo> ReadInfo(std::span<const std::uint8_t> payload) {
  DeviceInfo info;
  if (!payload.empty() && payload[0] != kDeviceProtocol) {
    info.version = payload[0];
    return info;
  }
  if (payload.size() != kInfoLength) return std::nullopt;
  Fields read(payload);
  read(info.version, info.firmware, info.reset_cause, info.capabilities);
  if (!read(info.state, DeviceState::kFault)) return std::nullopt;
  if (!read(info.fault, DeviceFault::kTiming)) return std::nullopt;
  read(info.period_min_us, info.period_max_us, info.convert_us, info.plan_values);
  read(info.relay_entries, info.uc.step_nv, info.uc.offset, info.uc_min, info.uc_max);
  for (DeviceChannel* channel : {&info.um, &info.ua, &info.ia}) {
    read(channel->step_nv, channel->offset, channel->bits);
  }
  read(info.relay_lines, info.safe_lines, info.make_first_lines);
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
  read(ack.flags, ack.bad_frames, ack.received, ack.next, ack.lines, ack.drops);
  return ack;
}

std::optional<DeviceSample> ReadSample(std::span<const std::uint8_t> payload) {
  if (payload.size() != kSampleLength) return std::nullopt;
  Fields read(payload);
  DeviceSample sample;
  read(sample.k, sample.t_us, sample.uc, sample.um, sample.ua, sample.ia);
  read(sample.count, sample.edge_age_us, sample.gate_count, sample.gate_tenth_us);
  read(sample.converted_us, sample.lines);
  if (!read(sample.state, DeviceState::kFault)) return std::nullopt;
  read(sample.flags);
  return sample;
}

}  // namespace faultlab::hardware
