#include "server/plots/value_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "server/plots/ticks.h"

namespace faultlab::server {
namespace {

std::string Significant(double value, int digits) {
  std::array<char, 40> text;
  const std::to_chars_result end = std::to_chars(
      text.data(), text.data() + text.size(), value, std::chars_format::general, digits);
  std::string number(text.data(), end.ptr);
  if (number.starts_with('-')) {
    number = "\u2212" + number.substr(1);
  }
  return number;
}

double Rounded(double value, int digits) {
  if (value == 0.0 || !std::isfinite(value)) {
    return value;
  }
  const double power = std::pow(10.0, digits - 1 - std::floor(std::log10(std::abs(value))));
  return std::round(value * power) / power;
}

std::string WithPrefix(double value, const std::string& unit, int digits) {
  struct Prefix {
    double factor;
    const char* letter;
  };
  constexpr std::array<Prefix, 7> kPrefixes = {
      {{1e6, "M"}, {1e3, "k"}, {1.0, ""}, {1e-3, "m"}, {1e-6, "µ"}, {1e-9, "n"}, {1e-12, "p"}}};
  const double magnitude = std::abs(Rounded(value, digits));
  for (const Prefix& prefix : kPrefixes) {
    constexpr double kSlack = 1.0 - 1e-12;  // 1e-6 / 1e-6 may be slightly below 1
    if (magnitude >= prefix.factor * kSlack) {
      return Significant(value / prefix.factor, digits) + " " + prefix.letter + unit;
    }
  }
  return Significant(value, digits) + " " + unit;
}

std::string WithPower(double value, const std::string& unit, int digits) {
  const double magnitude = std::abs(value);
  if (magnitude == 0.0 || !std::isfinite(value) || (magnitude >= 1e-2 && magnitude < 1e4)) {
    return Significant(value, digits) + " " + unit;
  }
  const int exponent =
      static_cast<int>(std::floor(std::log10(std::abs(Rounded(value, digits))) + 1e-12));
  const double mantissa = value / std::pow(10.0, exponent);
  return Significant(mantissa, digits) + "·10^{" + FormatNumber(exponent, 0) + "} " + unit;
}

}  // namespace

std::string ValueText(double value, std::string_view unit, int digits) {
  if (unit == "ohm") {
    return WithPrefix(value, "Ω", digits);
  }
  if (unit == "farad") {
    return WithPrefix(value, "F", digits);
  }
  if (unit == "kg m^2") {
    return WithPower(value, "kg m²", digits);
  }
  if (unit == "Nm/(rad/s)") {
    return WithPower(value, "Nm/(rad/s)", digits);
  }
  return WithPower(value, std::string(unit), digits);
}

std::string ComponentLabel(core::Component component) {
  const std::string_view name = core::Name(component);
  // R12 and Ra have an index; a name that somebody gave, such as Shunt, has none.
  const std::string_view index = name.substr(1);
  const bool number = std::ranges::all_of(index, [](char c) { return c >= '0' && c <= '9'; });
  return index.empty() || !(number || index.size() == 1)
             ? std::string(name)
             : std::string(name.substr(0, 1)) + "_{" + std::string(index) + "}";
}

}  // namespace faultlab::server
