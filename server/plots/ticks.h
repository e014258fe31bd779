#pragma once

#include <string>
#include <utility>
#include <vector>

namespace faultlab::server {

/// The tick positions of an axis and their labels.
struct Ticks {
  std::vector<double> at;           ///< multiples of 1, 2 or 5 times a power of ten
  std::vector<std::string> labels;  ///< one per tick, same number of decimals, true minus sign
  int exponent = 0;                 ///< labels are value / 10^exponent; usually 0
};

/// At most `count_max` ticks inside [from, to]; at least two when count_max allows.
/// Contract: from < to, both finite, count_max >= 2.
Ticks MakeTicks(double from, double to, int count_max);

/// `value` with `decimals` decimals and a true minus sign; no "-0".
std::string FormatNumber(double value, int decimals);

/// [from, to] widened by 5 % on each side; a single value is widened to a range.
std::pair<double, double> WithMargin(double from, double to);

}  // namespace faultlab::server
