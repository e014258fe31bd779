#include "hardware/lcm/unproven_rigs.h"

#include <algorithm>

namespace faultlab::hardware {

void UnprovenRigs::Hear(const std::string& name, RigRefusal why, Nanoseconds now) {
  if (names_.size() >= kNamesMax && !names_.contains(name)) {
    names_.erase(std::ranges::min_element(names_, [](const auto& a, const auto& b) {
      return a.second.heard_at < b.second.heard_at;
    }));
  }
  names_[name] = {name, now, why};
}

std::vector<UnprovenRigs::Name> UnprovenRigs::List(Nanoseconds now) const {
  std::vector<Name> list;
  for (const auto& [name, heard] : names_) {
    if (now - heard.heard_at < kKept) list.push_back(heard);
  }
  return list;
}

}  // namespace faultlab::hardware
