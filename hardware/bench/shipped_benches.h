#pragma once

#include <span>
#include <string_view>

namespace faultlab::hardware {

/// A file of benches/, built into the program.
struct ShippedBench {
  std::string_view name;  ///< "paper"
  std::string_view text;  ///< TOML
};

/// The paper's bench first.
std::span<const ShippedBench> ShippedBenches();

}  // namespace faultlab::hardware
