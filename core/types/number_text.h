#pragma once

#include <optional>
#include <string_view>

namespace faultlab::core {

/// The whole text as a finite number; nothing if it contains anything else.
std::optional<double> ParseNumber(std::string_view text);

/// As ParseNumber, but one of the letters p n u m k M may follow: "5.6k", "10u".
std::optional<double> ParseValue(std::string_view text);

}  // namespace faultlab::core
