#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/types/result.h"

namespace faultlab::hardware {

/// The secret that a rig and the servers allowed to use it share.
using RigKey = std::array<std::uint8_t, 32>;

/// Keyed BLAKE2b.
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

/// Whether these bytes end in their mac by this key, as messages did before protocol 3.
bool CarriesMac(std::span<const std::uint8_t> bytes, const RigKey& key);

}  // namespace faultlab::hardware
