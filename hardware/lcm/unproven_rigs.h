#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "hardware/clock.h"
#include "hardware/lcm/rig_finder.h"

namespace faultlab::hardware {

/// Names that somebody says on the bus without a proof. Anybody can invent them: at most 64 are
/// kept, the one that was not heard for the longest time leaves for a new one, and after a minute
/// of silence each leaves. Not thread-safe.
class UnprovenRigs {
 public:
  static constexpr std::size_t kNamesMax = 64;
  static constexpr Nanoseconds kKept = std::chrono::seconds(60);

  struct Name {
    std::string name;
    Nanoseconds heard_at{};
    RigRefusal why = RigRefusal::kNoKey;  ///< it is not believed
  };

  void Hear(const std::string& name, RigRefusal why, Nanoseconds now);
  void Remove(const std::string& name) { names_.erase(name); }
  std::vector<Name> List(Nanoseconds now) const;

 private:
  std::map<std::string, Name> names_;
};

}  // namespace faultlab::hardware
