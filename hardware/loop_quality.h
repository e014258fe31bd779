#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace faultlab::hardware {

/// How well a paced loop kept its deadlines. A plain value: subtract two of them for one run.
struct LoopQuality {
  /// Upper bounds of the lateness histogram, microseconds; the last bucket has no bound.
  static constexpr std::array<std::int64_t, 12> kBoundsUs = {
      20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000, 100000};
  static constexpr std::size_t kBuckets = kBoundsUs.size() + 1;

  std::array<std::uint64_t, kBuckets> lateness{};  ///< ticks by lateness
  std::uint64_t ticks = 0;
  std::uint64_t overruns = 0;      ///< ticks that came a whole period late or more
  std::uint64_t missed_ticks = 0;  ///< periods that passed without a tick
  double lateness_sum_s = 0.0;
  double lateness_worst_s = 0.0;
  bool fifo = false;  ///< the loop runs under SCHED_FIFO

  void Count(double lateness_s);
  /// Upper bound of the bucket that holds the q-quantile, seconds; infinity for the last bucket.
  double QuantileBound(double q) const;
  /// What was added since `before`; lateness_worst_s stays that of the whole life.
  LoopQuality Since(const LoopQuality& before) const;
};

}  // namespace faultlab::hardware
