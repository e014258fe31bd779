#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace faultlab::core {

/// The whole text as a finite number; nothing if it contains anything else.
std::optional<double> ParseNumber(std::string_view text);

/// As ParseNumber, but as people write values of parts: "5.6k", "10u", "4k7", "4R7", "47 pF",
/// "33kohm".
std::optional<double> ParseValue(std::string_view text);

/// With as few digits as distinguish the number from its neighbours.
std::string Shortest(double number);
/// As printf writes it.
[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...);

}  // namespace faultlab::core
