#include "server/report/report_section.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/types/number_text.h"
#include "server/plots/value_text.h"

namespace faultlab::server {
namespace {

constexpr int kDigitsOfValues = 4;

std::string Signed(std::string text) {
  return text.starts_with('-') ? "\u2212" + text.substr(1) : text;
}

std::string Fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  const std::string number = core::Format("%.*f", decimals, value);
  return number.find_first_not_of("-0.") == std::string::npos ? Signed(number.substr(value < 0.0))
                                                              : Signed(number);
}

/// "10^{−6}" -> "10⁻⁶": the page's text has no other markup.
std::string Raised(const std::string& text) {
  static const std::array<const char*, 10> kRaised = {
      "⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  const std::size_t at = text.find("^{");
  const std::size_t end = text.find('}', at);
  if (at == std::string::npos || end == std::string::npos) return text;
  std::string out = text.substr(0, at);
  std::string power = text.substr(at + 2, end - at - 2);
  const std::string minus = "\u2212";
  if (power.starts_with(minus)) {
    out += "⁻";
    power.erase(0, minus.size());
  }
  for (const char c : power) {
    if (c >= '0' && c <= '9') out += kRaised[static_cast<std::size_t>(c - '0')];
  }
  return out + text.substr(end + 1);
}

std::string Digits(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  const std::string number = core::Format("%.*g", digits, value);
  const std::size_t power = number.find('e');
  if (power == std::string::npos) return Signed(number);
  if (number[power + 1] != '-') return Fixed(value, 0);
  const std::string digits_of = number.substr(number.find_first_not_of('0', power + 2));
  return Signed(Raised(std::string(number.substr(0, power)) + "·10^{\u2212" + digits_of + "}"));
}

std::string Factor(double value, int digits) {
  if (!std::isfinite(value) || value <= 0.0) return "–";
  return Fixed(value, std::max(0, digits - 1 - static_cast<int>(std::floor(std::log10(value)))));
}

std::string Number(std::optional<double> value) {
  if (!value || !std::isfinite(*value)) return "–";
  constexpr int kDecimalsMax = 6;
  constexpr double kSmall = 1e-4;
  const double size = std::abs(*value);
  if (size == 0.0) return "0";
  if (size < kSmall) return Digits(*value, kDigitsOfValues);
  const int power = static_cast<int>(std::floor(std::log10(size)));
  return Fixed(*value, std::clamp(kDigitsOfValues - 1 - power, 0, kDecimalsMax));
}

}  // namespace

std::string ReportSection::Local(std::string number) const {
  std::replace(number.begin(), number.end(), '.', words_.decimal_sign);
  return number;
}

std::string ReportSection::Digits(double value, int digits) const {
  return Local(server::Digits(value, digits));
}

std::string ReportSection::Fixed(double value, int decimals) const {
  return Local(server::Fixed(value, decimals));
}

std::string ReportSection::Number(std::optional<double> value) const {
  return Local(server::Number(value));
}

std::string ReportSection::Factor(double value, int digits) const {
  return Local(server::Factor(value, digits));
}

std::string ReportSection::ValueOf(core::Component component, double value) const {
  if (!std::isfinite(value)) return "–";
  return Local(Raised(ValueText(value, core::Unit(component), kDigitsOfValues)));
}

std::string ReportSection::WithError(double value, double sigma, std::string_view unit) const {
  return Local(Raised(ValueWithErrorText(value, sigma, unit, kDigitsOfValues)));
}

std::string Joined(std::span<const core::Component> components, std::string_view word) {
  std::string out;
  for (const core::Component component : components) {
    if (!out.empty()) out.append(" ").append(word).append(" ");
    out += core::Name(component);
  }
  return out;
}

std::string Readable(const std::string& iso) {
  constexpr std::size_t kToTheSecond = 19;
  if (iso.size() < kToTheSecond) return iso;
  std::string out = iso.substr(0, kToTheSecond) + " UTC";
  out[10] = ' ';
  return out;
}

}  // namespace faultlab::server
