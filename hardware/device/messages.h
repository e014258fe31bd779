#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace faultlab::hardware {

/// The messages of the device protocol, byte by byte in PROTOCOL.md.
inline constexpr std::uint8_t kDeviceProtocol = 1;

enum class DeviceMessage : std::uint8_t {
  kHello = 0x01,
  kPlan = 0x02,
  kData = 0x03,
  kArm = 0x04,
  kStart = 0x05,
  kHeartbeat = 0x06,
  kSafe = 0x07,
  kRelay = 0x08,
  kClear = 0x09,
  kResend = 0x0a,
  kInfo = 0x81,
  kAck = 0x82,
  kSample = 0x83,
};

enum class DeviceState : std::uint8_t { kSafe = 0, kArmed = 1, kRun = 2, kFault = 3 };
enum class DeviceFault : std::uint8_t {
  kNone = 0,
  kCommunication = 1,
  kUnderrun = 2,
  kRelay = 3,
  kTiming = 4,
};
enum class DeviceError : std::uint8_t {
  kNone = 0,
  kLength = 1,
  kType = 2,
  kState = 3,
  kRange = 4,
  kOffset = 5,
  kFull = 6,
  kLate = 7,
  kVersion = 8,
};

/// One sentence for a person.
std::string_view TextOf(DeviceFault fault);
std::string_view TextOf(DeviceError error);
/// "HELLO", "PLAN", ..
std::string_view NameOf(DeviceMessage message);
/// Of INFO: "power-up", "watchdog", ..
std::string_view ResetCauseText(std::uint8_t cause);

inline constexpr std::uint8_t kRelaysSettled = 0x01;
inline constexpr std::uint32_t kRelayNow = 0xffffffffu;
inline constexpr std::uint16_t kNoEdge = 0xffffu;
inline constexpr std::size_t kDataValuesMax = 24;

/// Terminal volts = (code - offset) * step_nv * 1e-9.
struct DeviceChannel {
  std::uint32_t step_nv = 0;
  std::int16_t offset = 0;
  std::uint8_t bits = 0;  ///< of the converter

  double ToVolt(int code) const { return (code - offset) * (step_nv * 1e-9); }
};

struct DeviceInfo {
  static constexpr std::uint16_t kUm = 1, kUa = 2, kIa = 4, kEncoder = 8, kDirection = 16,
                                 kEdgeTime = 32;

  std::uint8_t version = 0;
  std::uint16_t firmware = 0;
  std::uint8_t reset_cause = 0;
  std::uint16_t capabilities = 0;
  DeviceState state = DeviceState::kSafe;
  DeviceFault fault = DeviceFault::kNone;
  std::uint32_t period_min_us = 0;
  std::uint32_t period_max_us = 0;
  std::uint16_t convert_us = 0;   ///< how long the conversions of a sample take
  std::uint16_t plan_values = 0;  ///< that it holds beyond the sample that is running
  std::uint8_t relay_entries = 0;
  DeviceChannel uc;
  std::int16_t uc_min = 0;  ///< codes
  std::int16_t uc_max = 0;
  DeviceChannel um;
  DeviceChannel ua;
  DeviceChannel ia;
  std::uint32_t relay_lines = 0;
  std::uint32_t safe_lines = 0;
  std::uint32_t make_first_lines = 0;
};

struct DeviceAck {
  DeviceMessage request{};
  DeviceError error = DeviceError::kNone;
  DeviceState state = DeviceState::kSafe;
  DeviceFault fault = DeviceFault::kNone;
  std::uint8_t flags = 0;
  std::uint8_t bad_frames = 0;  ///< that the device could not read; stops at 255
  std::uint32_t received = 0;   ///< values of the plan
  std::uint32_t next = 0;       ///< the sample whose tick comes next
  std::uint32_t lines = 0;      ///< connected, read back
  std::uint16_t drops = 0;      ///< samples that the device could not send at once
};

struct DeviceSample {
  std::uint32_t k = 0;
  std::uint32_t t_us = 0;  ///< of the tick, from the first one; wraps at 2^32
  std::int16_t uc = 0;
  std::int16_t um = 0;
  std::int16_t ua = 0;
  std::int16_t ia = 0;
  std::int32_t count = 0;         ///< encoder pulses, signed; wraps
  std::uint16_t edge_age_us = 0;  ///< from the newest pulse to the count, or kNoEdge
  std::int16_t gate_count = 0;    ///< pulses during the conversions
  std::uint16_t gate_tenth_us =
      0;  ///< from the newest pulse before them to the newest of them; or 0
  std::uint32_t converted_us = 0;
  std::uint32_t lines = 0;
  DeviceState state = DeviceState::kSafe;
  std::uint8_t flags = 0;
};

using Payload = std::vector<std::uint8_t>;

Payload HelloPayload();
Payload PlanPayload(std::uint32_t samples, std::uint32_t period_us, std::uint32_t delta_us);
Payload DataPayload(std::uint32_t first, std::span<const std::int16_t> codes);
Payload ArmPayload(std::uint16_t watchdog_ms, std::uint16_t gap_us, std::uint16_t settle_us);
Payload RelayPayload(std::uint32_t at, std::uint32_t lines);
Payload ResendPayload(std::uint32_t k);

/// Nothing for a payload of another length, or with a state or error that does not exist. An INFO
/// of another version has its version alone.
std::optional<DeviceInfo> ReadInfo(std::span<const std::uint8_t> payload);
std::optional<DeviceAck> ReadAck(std::span<const std::uint8_t> payload);
std::optional<DeviceSample> ReadSample(std::span<const std::uint8_t> payload);

}  // namespace faultlab::hardware
