#include "hardware/relay_lines.h"
#include "core/types/number_text.h"

#include <bit>

namespace faultlab::hardware {

std::string Hex(std::uint32_t lines) {
  return core::Format("0x%08x", lines);
}

std::string LineDifference(std::uint32_t written, std::uint32_t read) {
  return "relay lines " + Hex(written) + " were written, " + Hex(read) +
         " are read back (first difference: Do" + std::to_string(std::countr_zero(read ^ written)) +
         ")";
}

}  // namespace faultlab::hardware
