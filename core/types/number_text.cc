#include "core/types/number_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <string>

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
  for (const std::string_view unit : {"ohm", "\u2126", "\u03a9", "F", "H"}) {
    if (text.size() > unit.size() && text.ends_with(unit)) {
      text.remove_suffix(unit.size());
      break;
    }
  }
  while (text.ends_with(' ')) text.remove_suffix(1);
  struct Prefix {
    std::string_view letter;
    double factor;
  };
  // "R" stands for the decimal point of ohms: 4R7.
  constexpr std::array kPrefixes{Prefix{"p", 1e-12},
                                 Prefix{"n", 1e-9},
                                 Prefix{"u", 1e-6},
                                 Prefix{"\u00b5", 1e-6},
                                 Prefix{"\u03bc", 1e-6},
                                 Prefix{"m", 1e-3},
                                 Prefix{"R", 1.0},
                                 Prefix{"k", 1e3},
                                 Prefix{"K", 1e3},
                                 Prefix{"M", 1e6}};
  for (const auto& [letter, factor] : kPrefixes) {
    const std::size_t at = text.find(letter);
    if (at == std::string_view::npos) continue;
    std::string_view whole = text.substr(0, at);
    while (whole.ends_with(' ')) whole.remove_suffix(1);
    const std::string_view decimals = text.substr(at + letter.size());
    std::string digits(whole);
    if (!decimals.empty()) {
      const bool plain = decimals.find_first_not_of("0123456789") == std::string_view::npos;
      const bool whole_number = !whole.empty() && whole.find('.') == std::string_view::npos;
      if (!plain || !whole_number) return std::nullopt;
      digits.append(".").append(decimals);
    }
    const std::optional<double> number = ParseNumber(digits);
    const double value = number ? *number * factor : 0.0;
    return number && std::isfinite(value) ? std::optional(value) : std::nullopt;
  }
  return ParseNumber(text);
}

std::string Shortest(double number) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return {text.data(), end};
}

std::string Format(const char* format, ...) {
  std::va_list given;
  va_start(given, format);
  std::va_list again;
  va_copy(again, given);
  const int size = std::vsnprintf(nullptr, 0, format, given);
  va_end(given);
  std::string out(static_cast<std::size_t>(std::max(size, 0)), '\0');
  std::vsnprintf(out.data(), out.size() + 1, format, again);
  va_end(again);
  return out;
}

}  // namespace faultlab::core
