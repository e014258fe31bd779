#include "core/types/number_text.h"

#include <charconv>
#include <cmath>

namespace faultlab::core {

std::optional<double> ParseNumber(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
  }
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const std::from_chars_result read = std::from_chars(text.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::optional<double> ParseValue(std::string_view text) {
  if (text.empty()) {
    return std::nullopt;
  }
  double factor = 0.0;
  switch (text.back()) {
    case 'p':
      factor = 1e-12;
      break;
    case 'n':
      factor = 1e-9;
      break;
    case 'u':
      factor = 1e-6;
      break;
    case 'm':
      factor = 1e-3;
      break;
    case 'k':
      factor = 1e3;
      break;
    case 'M':
      factor = 1e6;
      break;
    default:
      return ParseNumber(text);
  }
  const std::optional<double> number = ParseNumber(text.substr(0, text.size() - 1));
  const double value = number ? *number * factor : 0.0;
  return number && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace faultlab::core
