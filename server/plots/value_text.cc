#include "server/plots/value_text.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/types/number_text.h"
#include "server/plots/ticks.h"

namespace faultlab::server {
namespace {

std::string Significant(double value, int digits) {
  std::string number = core::Format("%.*g", digits, value);
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

struct Prefix {
  double factor;
  const char* letter;
};

/// That of the value as it is written.
Prefix PrefixOf(double value) {
  constexpr std::array<Prefix, 7> kPrefixes = {
      {{1e6, "M"}, {1e3, "k"}, {1.0, ""}, {1e-3, "m"}, {1e-6, "µ"}, {1e-9, "n"}, {1e-12, "p"}}};
  constexpr double kSlack = 1.0 - 1e-12;  // 1e-6 / 1e-6 may be slightly below 1
  for (const Prefix& prefix : kPrefixes) {
    if (std::abs(value) >= prefix.factor * kSlack) return prefix;
  }
  return {1.0, ""};
}

std::string WithPrefix(double value, const std::string& unit, int digits) {
  const Prefix prefix = PrefixOf(Rounded(value, digits));
  return Significant(value / prefix.factor, digits) + " " + prefix.letter + unit;
}

bool IsPowered(double value) {
  const double magnitude = std::abs(value);
  return magnitude != 0.0 && std::isfinite(value) && (magnitude < 1e-2 || magnitude >= 1e4);
}

/// One significant digit of the error, two when it begins with 1.
int DecimalsFor(double sigma) {
  constexpr int kMost = 8;
  constexpr double kBeginsWithOne = 1.95;
  const int power = static_cast<int>(std::floor(std::log10(sigma)));
  const bool two = sigma / std::pow(10.0, power) < kBeginsWithOne;
  return std::clamp((two ? 1 : 0) - power, 0, kMost);
}

std::string WithPower(double value, const std::string& unit, int digits) {
  if (!IsPowered(value)) return Significant(value, digits) + " " + unit;
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
    return WithPower(value, "kg·m²", digits);
  }
  if (unit == "Nm/(rad/s)") {
    return WithPower(value, "Nm·s/rad", digits);
  }
  return WithPower(value, std::string(unit), digits);
}

std::string ValueWithErrorText(double value, double sigma, std::string_view unit, int digits) {
  if (!std::isfinite(value) || !std::isfinite(sigma) || sigma <= 0.0) {
    return ValueText(value, unit, digits);
  }
  const auto both = [&](double scale) {
    const int decimals = DecimalsFor(sigma / scale);
    return FormatNumber(value / scale, decimals) + " ± " + FormatNumber(sigma / scale, decimals);
  };
  if (unit == "ohm" || unit == "farad") {
    const Prefix prefix = PrefixOf(value);
    return both(prefix.factor) + " " + prefix.letter + (unit == "ohm" ? "Ω" : "F");
  }
  const std::string shown = unit == "kg m^2"       ? "kg·m²"
                            : unit == "Nm/(rad/s)" ? "Nm·s/rad"
                                                   : std::string(unit);
  if (!IsPowered(value)) return both(1.0) + " " + shown;
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value))));
  return "(" + both(std::pow(10.0, exponent)) + ")·10^{" + FormatNumber(exponent, 0) + "} " + shown;
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
