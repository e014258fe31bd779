#include "hardware/relay_lines.h"

#include <bit>
#include <cstdio>

namespace faultlab::hardware {

std::string Hex(std::uint32_t lines) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%08x", lines);
  return text;
}

std::string LineDifference(std::uint32_t written, std::uint32_t read) {
  return "relay lines " + Hex(written) + " were written, " + Hex(read) +
         " are read back (first difference: Do" + std::to_string(std::countr_zero(read ^ written)) +
         ")";
}

}  // namespace faultlab::hardware
