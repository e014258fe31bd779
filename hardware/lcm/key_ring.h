#pragma once

#include <map>
#include <optional>
#include <string>

#include "hardware/clock.h"
#include "hardware/lcm/rig_key.h"

namespace faultlab::hardware {

/// The keys of a folder. It is read again every two seconds while somebody asks: a key that is
/// copied there works without a restart, and a flood of names costs no look at the disk each. Not
/// thread-safe.
class KeyRing {
 public:
  explicit KeyRing(std::string directory) : directory_(std::move(directory)) {}

  std::optional<RigKey> Find(const std::string& rig, Nanoseconds now);

 private:
  void Read();

  const std::string directory_;
  std::map<std::string, RigKey> keys_;
  std::optional<Nanoseconds> read_at_;
};

}  // namespace faultlab::hardware
