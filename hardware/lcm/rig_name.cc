#include "hardware/lcm/rig_name.h"

#include <algorithm>

#include "core/types/utf8.h"

namespace faultlab::hardware {

bool IsRigName(const std::string& name) {
  return !name.empty() && name.size() <= 40 && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

std::string ShownText(const std::string& text, std::size_t bytes_max) {
  return core::IsUtf8(text) ? std::string(core::CutUtf8(text, bytes_max)) : "(not UTF-8)";
}

}  // namespace faultlab::hardware
