#include "hardware/lcm/rig_name.h"

#include <algorithm>
#include <cstdint>

namespace faultlab::hardware {

bool IsRigName(const std::string& name) {
  return !name.empty() && name.size() <= 40 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

bool IsUtf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto head = static_cast<std::uint8_t>(text[at++]);
    if (head < 0x80) continue;
    const int more = head >= 0xf0 ? 3 : head >= 0xe0 ? 2 : 1;
    if (head < 0xc2 || head > 0xf4) return false;
    std::uint32_t point = head & (0x3fu >> more);
    for (int i = 0; i < more; ++i) {
      if (at == text.size()) return false;
      const auto byte = static_cast<std::uint8_t>(text[at++]);
      if ((byte & 0xc0u) != 0x80u) return false;
      point = point << 6 | (byte & 0x3fu);
    }
    constexpr std::uint32_t kShortest[] = {0, 0x80, 0x800, 0x10000};
    const bool surrogate = point >= 0xd800 && point <= 0xdfff;
    if (point < kShortest[more] || point > 0x10ffff || surrogate) return false;
  }
  return true;
}

std::string ShownText(const std::string& text, std::size_t bytes_max) {
  if (!IsUtf8(text)) return "(not UTF-8)";
  if (text.size() <= bytes_max) return text;
  std::size_t end = bytes_max;
  while (end > 0 && (static_cast<std::uint8_t>(text[end]) & 0xc0u) == 0x80u) --end;
  return text.substr(0, end);
}

}  // namespace faultlab::hardware
