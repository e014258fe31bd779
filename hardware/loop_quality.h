#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace faultlab::hardware {

/// Times by bucket. A plain value: subtract two of them for what lies between.
struct TimeHistogram {
  /// Upper bounds, microseconds; the last bucket has none. 11 ms is a tick of 100 Hz and 1 ms.
  static constexpr std::array<std::int64_t, 13> kBoundsUs = {
      20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 11000, 20000, 50000, 100000};
  static constexpr std::size_t kBuckets = kBoundsUs.size() + 1;

  std::array<std::uint64_t, kBuckets> counts{};  ///< of each bucket alone
  double sum_s = 0.0;
  double worst_s = 0.0;

  std::uint64_t count() const;
  void Count(double time_s);
  void Add(const TimeHistogram& other);
  /// Upper bound of the bucket that holds the q-quantile, seconds, but not above the worst;
  /// 0 when nothing was counted.
  double QuantileBound(double q) const;
  /// What was added since `before`. If the worst is older, the worst since then is known by its
  /// bucket only: the bound of that is given.
  TimeHistogram Since(const TimeHistogram& before) const;
};

/// How well a paced loop kept its deadlines, and how soon it did what it was told.
struct LoopQuality {
  TimeHistogram lateness;  ///< of each wake-up of the loop
  /// From Command's acceptance until the tick's drive and relay lines were written; a board that
  /// rests between two switchings counts in full.
  TimeHistogram actuation;
  std::uint64_t overruns = 0;      ///< ticks that came a whole period late or more
  std::uint64_t missed_ticks = 0;  ///< periods that passed without a tick
  bool fifo = false;               ///< the loop runs under SCHED_FIFO

  void Add(const LoopQuality& other);
  /// Everything, when `before` has more: its counters were of an earlier start.
  LoopQuality Since(const LoopQuality& before) const;
};

}  // namespace faultlab::hardware
