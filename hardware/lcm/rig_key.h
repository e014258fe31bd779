#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/types/result.h"
#include "hardware/lcm/message_codec.h"

namespace faultlab::hardware {

/// The secret that a rig and the servers allowed to use it share.
using RigKey = std::array<std::uint8_t, 32>;

/// UDP multicast knows no sender: each message carries keyed BLAKE2b of itself.
using Mac = std::array<std::uint8_t, 32>;
Mac ComputeMac(const RigKey& key, std::span<const std::uint8_t> bytes);
/// In constant time.
bool SameMac(const Mac& a, const Mac& b);

/// DIR/NAME.key, 64 hex digits; nothing when there is no such file, kInvalid when it is not that.
core::Result<std::optional<RigKey>> LoadRigKey(const std::string& directory,
                                               const std::string& rig);
/// The same; makes directory and key (readable by its owner alone) on the first call.
core::Result<RigKey> LoadOrMakeRigKey(const std::string& directory, const std::string& rig);
/// `directory`, or $HOME/.faultlab/keys when empty.
std::string KeyDirectory(const std::string& directory);

/// A random number that no other start of a program shares.
std::int64_t RandomId();

/// Encoded, with the mac of all that stands before it. `mac` is the last field of every signed
/// type.
template <typename Message>
std::vector<std::uint8_t> SignedBytes(const Message& message, const RigKey& key) {
  std::vector<std::uint8_t> bytes = ToBytes(message);
  const std::span<std::uint8_t> tail = std::span(bytes).last(std::tuple_size_v<Mac>);
  const Mac mac = ComputeMac(key, std::span(bytes).first(bytes.size() - tail.size()));
  std::copy(mac.begin(), mac.end(), tail.begin());
  return bytes;
}

/// Whether these bytes end in their mac by this key, of whatever type they are.
bool CarriesMac(std::span<const std::uint8_t> bytes, const RigKey& key);

/// The message, if it carries the key's mac, which is checked first.
template <typename Message>
std::optional<Message> Verified(std::span<const std::uint8_t> bytes, const RigKey& key) {
  if (!CarriesMac(bytes, key)) return std::nullopt;
  return FromBytes<Message>(bytes);
}

}  // namespace faultlab::hardware
