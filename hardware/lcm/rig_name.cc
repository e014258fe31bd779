#include "hardware/lcm/rig_name.h"

#include <algorithm>

namespace faultlab::hardware {

bool IsRigName(const std::string& name) {
  return !name.empty() && name.size() <= 40 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

}  // namespace faultlab::hardware
