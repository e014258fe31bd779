#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace faultlab::core {

/// Number of samples of a stretch that has to satisfy two needs: at least `samples` of them, for
/// its statistics, and at least the time that so many samples take at 100 Hz, for the motor and its
/// friction. At 100 Hz and below it is `samples`; above, it grows with the rate.
inline std::size_t SpanOf(std::size_t samples, double period_s) {
  constexpr double kReferencePeriodS = 0.01;
  const double scaled = std::round(static_cast<double>(samples) * kReferencePeriodS / period_s);
  return std::max(samples, static_cast<std::size_t>(scaled));
}

}  // namespace faultlab::core
