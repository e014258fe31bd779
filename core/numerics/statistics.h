#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace faultlab::core {

struct Interval {
  double low = 0.0;
  double high = 0.0;
};

/// Wilson's 95 % interval of a probability seen `hits` times in `trials`.
inline Interval WilsonInterval(int hits, int trials) {
  if (trials == 0) {
    return {0.0, 1.0};
  }
  constexpr double kZ = 1.959964;
  const double n = trials;
  const double p = hits / n;
  const double centre = p + kZ * kZ / (2.0 * n);
  const double half = kZ * std::sqrt(p * (1.0 - p) / n + kZ * kZ / (4.0 * n * n));
  const double scale = 1.0 + kZ * kZ / n;
  return {std::max(0.0, (centre - half) / scale), std::min(1.0, (centre + half) / scale)};
}

/// Exact 95 % interval of a Poisson mean of which `count` events were seen.
inline Interval PoissonInterval(int count) {
  const auto at_most = [](int k, double mean) {
    double term = std::exp(-mean);
    double sum = term;
    for (int i = 1; i <= k; ++i) {
      term *= mean / i;
      sum += term;
    }
    return sum;
  };
  const auto solve = [&](int k, double probability) {
    double low = 0.0;
    double high = 10.0 + 3.0 * count;
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (at_most(k, middle) > probability ? low : high) = middle;
    }
    return 0.5 * (low + high);
  };
  return {count == 0 ? 0.0 : solve(count - 1, 0.975), solve(count, 0.025)};
}

/// Of a population; 0 if there are none.
inline double StandardDeviation(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto n = static_cast<double>(values.size());
  double sum = 0.0;
  for (const double value : values) sum += value;
  double squares = 0.0;
  for (const double value : values) squares += (value - sum / n) * (value - sum / n);
  return std::sqrt(squares / n);
}

/// The share-quantile of the values; NaN if there are none. Entries of undetected faults may be
/// infinite.
inline double Quantile(std::vector<double> values, double share) {
  if (values.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  std::sort(values.begin(), values.end());
  const auto at =
      static_cast<std::size_t>(std::min(static_cast<double>(values.size()) - 1.0,
                                        std::floor(share * static_cast<double>(values.size()))));
  return values[at];
}

}  // namespace faultlab::core
