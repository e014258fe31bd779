#pragma once

// LCM's datagrams, all numbers big-endian:
//   LC02  sequence 4,                                                  channel NUL, message
//   LC03  sequence 4, message size 4, offset 4, number 2, count 2,     a fragment of the message
// A fragment of number 0 begins with channel NUL. liblcm 1.3.1 believes these numbers (offset +
// size is added in 32 bits and the copy goes outside of its buffer), so it reads no datagram of
// ours.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

namespace faultlab::hardware {

/// A longer message is neither sent nor received. Ours fit a datagram of 64 KiB.
inline constexpr std::size_t kLcmMessageBytesMax = 1u << 20;
/// liblcm's smallest fragments are of 1423 bytes (macOS): 737 for the longest message.
inline constexpr std::size_t kLcmFragmentsMax = 1024;
inline constexpr std::size_t kLcmChannelBytesMax = 63;

/// Points into its datagram. A message in one datagram is fragment 0 of 1.
struct LcmPacket {
  std::uint32_t sequence = 0;
  std::uint32_t message_bytes = 0;        ///< at most kLcmMessageBytesMax
  std::uint32_t offset = 0;               ///< offset + payload.size() <= message_bytes
  std::uint16_t number = 0;               ///< < count
  std::uint16_t count = 1;                ///< at most kLcmFragmentsMax
  std::string_view channel;               ///< of number 0; at most kLcmChannelBytesMax
  std::span<const std::uint8_t> payload;  ///< not empty in a fragment; all of it when count is 1
};

/// Nothing when a number is outside of the bounds above.
std::optional<LcmPacket> ReadLcmPacket(std::span<const std::uint8_t> datagram);

/// One datagram in two parts, one behind the other.
using SendLcmPacket =
    std::function<void(std::span<const std::uint8_t> head, std::span<const std::uint8_t> payload)>;

/// The datagrams of a message, cut where liblcm cuts. False, and nothing sent, when the message or
/// the channel is longer than its bound or the channel holds a NUL.
bool WriteLcmPackets(std::uint32_t sequence,
                     std::string_view channel,
                     std::span<const std::uint8_t> message,
                     const SendLcmPacket& send);

}  // namespace faultlab::hardware
