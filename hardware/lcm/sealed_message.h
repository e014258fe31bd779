#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hardware/lcm/channels.h"
#include "hardware/lcm/message_codec.h"
#include "hardware/lcm/rig_key.h"

namespace faultlab::hardware {

inline constexpr std::size_t kShortMessageBytes = 1023;

/// Everybody on the bus hears everything: plans, faults and what the rig did about them are sealed,
/// always.
///
///   rig_sealed_t: rig, protocol, nonce (random), box
///   box = XChaCha20-Poly1305 (libsodium) of the message, padded, under a key derived from the
///         rig's; additional data: channel, rig, and all before the box
///   padded to 1024 bytes (messages of up to kShortMessageBytes), or to a multiple of 4096;
///   commands always to the latter
///
/// A box that is replayed on another channel (direction), as another rig's or with another protocol
/// does not open. That it is of this lease and not heard before is inside: boot, epoch, counter.
/// The rest is seen by whoever listens: which rig speaks, when, and the padded length.
std::vector<std::uint8_t> SealBytes(std::span<const std::uint8_t> message,
                                    const std::string& channel,
                                    const std::string& rig,
                                    const RigKey& key,
                                    std::int32_t protocol = kProtocol);

struct OpenedBytes {
  std::int32_t protocol = 0;
  std::vector<std::uint8_t> message;
};
/// Nothing unless the key's owner sealed it for this channel and rig. The tag is checked before
/// anything is read.
std::optional<OpenedBytes> OpenSealed(std::span<const std::uint8_t> bytes,
                                      const std::string& channel,
                                      const std::string& rig,
                                      const RigKey& key);

/// The rig that sealed bytes name, before anything of them is believed.
std::optional<std::string> SealedRig(std::span<const std::uint8_t> bytes);

template <typename Message>
std::vector<std::uint8_t> Sealed(const Message& message,
                                 const std::string& channel,
                                 const RigKey& key) {
  return SealBytes(ToBytes(message), channel, message.rig, key);
}

/// The message, if it is one of this type in our protocol.
template <typename Message>
std::optional<Message> Opened(std::span<const std::uint8_t> bytes,
                              const std::string& channel,
                              const std::string& rig,
                              const RigKey& key) {
  const std::optional<OpenedBytes> opened = OpenSealed(bytes, channel, rig, key);
  if (!opened || opened->protocol != kProtocol) return std::nullopt;
  std::optional<Message> message = FromBytes<Message>(opened->message);
  if (message && message->rig != rig) return std::nullopt;
  return message;
}

}  // namespace faultlab::hardware
