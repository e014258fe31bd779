#include "server/plots/ticks.h"

#include <algorithm>
#include <cmath>

#include "core/types/check.h"
#include "core/types/number_text.h"

namespace faultlab::server {
namespace {

constexpr int kEngineering = 3;    // exponents are multiples of three
constexpr double kTinyMax = 2e-3;  // for smaller values the labels get an exponent
constexpr double kHugeMin = 1e5;
constexpr double kEdgeSlack = 1e-9;  // of a step: a tick on the very edge counts as inside

int ExponentFor(double magnitude) {
  if (magnitude == 0.0 || (magnitude >= kTinyMax && magnitude < kHugeMin)) {
    return 0;
  }
  return kEngineering * static_cast<int>(std::floor(std::log10(magnitude) / kEngineering));
}

}  // namespace

std::string FormatNumber(double value, int decimals) {
  const std::string number = core::Format("%.*f", decimals, value);
  if (number.front() != '-') {
    return number;
  }
  const bool zero = number.find_first_of("123456789") == std::string::npos;
  return zero ? number.substr(1) : "\u2212" + number.substr(1);
}

Ticks MakeTicks(double from, double to, int count_max) {
  LAB_CHECK(std::isfinite(from) && std::isfinite(to) && from < to && count_max >= 2, from, to);
  const double raw = (to - from) / count_max;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  Ticks ticks;
  for (const double mantissa : {1.0, 2.0, 5.0, 10.0, 20.0}) {
    const double step = mantissa * power;
    const double first = std::ceil(from / step - kEdgeSlack);
    const double last = std::floor(to / step + kEdgeSlack);
    if (last - first + 1 > count_max) {
      continue;
    }
    for (double k = first; k <= last; ++k) {
      ticks.at.push_back(k * step);
    }
    ticks.exponent = ExponentFor(std::max(std::abs(from), std::abs(to)));
    const double shown_step = step / std::pow(10.0, ticks.exponent);
    const int decimals =
        std::max(0, static_cast<int>(-std::floor(std::log10(shown_step) + kEdgeSlack)));
    for (const double at : ticks.at) {
      ticks.labels.push_back(FormatNumber(at / std::pow(10.0, ticks.exponent), decimals));
    }
    return ticks;
  }
  return ticks;
}

std::pair<double, double> WithMargin(double from, double to) {
  constexpr double kMargin = 0.05;
  const double span = to - from;
  const double magnitude = std::max(std::abs(from), std::abs(to));
  constexpr double kFlat = 1e-9;  // of the magnitude: a constant signal
  if (span <= kFlat * magnitude || span == 0.0) {
    const double room = magnitude > 0.0 ? 0.1 * magnitude : 1.0;
    return {from - room, to + room};
  }
  return {from - kMargin * span, to + kMargin * span};
}

}  // namespace faultlab::server
