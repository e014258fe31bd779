#include "hardware/loop_quality.h"

#include <algorithm>
#include <numeric>

namespace faultlab::hardware {

std::uint64_t TimeHistogram::count() const {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

void TimeHistogram::Count(double time_s) {
  const double time_us = time_s * 1e6;
  std::size_t bucket = 0;
  while (bucket < kBoundsUs.size() && time_us > static_cast<double>(kBoundsUs[bucket])) ++bucket;
  ++counts[bucket];
  sum_s += time_s;
  worst_s = std::max(worst_s, time_s);
}

void TimeHistogram::Add(const TimeHistogram& other) {
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) counts[bucket] += other.counts[bucket];
  sum_s += other.sum_s;
  worst_s = std::max(worst_s, other.worst_s);
}

double TimeHistogram::QuantileBound(double q) const {
  const double wanted = q * static_cast<double>(count());
  double seen = 0.0;
  for (std::size_t bucket = 0; bucket < kBoundsUs.size(); ++bucket) {
    seen += static_cast<double>(counts[bucket]);
    if (seen >= wanted) {
      return std::min(static_cast<double>(kBoundsUs[bucket]) * 1e-6, worst_s);
    }
  }
  return worst_s;
}

TimeHistogram TimeHistogram::Since(const TimeHistogram& before) const {
  TimeHistogram since = *this;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    since.counts[bucket] -= before.counts[bucket];
  }
  since.sum_s -= before.sum_s;
  if (worst_s > before.worst_s) return since;
  std::size_t last = kBuckets;
  while (last > 0 && since.counts[last - 1] == 0) --last;
  since.worst_s = last == 0 ? 0.0
                  : last == kBuckets
                      ? worst_s
                      : std::min(worst_s, static_cast<double>(kBoundsUs[last - 1]) * 1e-6);
  return since;
}

void LoopQuality::Add(const LoopQuality& other) {
  lateness.Add(other.lateness);
  actuation.Add(other.actuation);
  overruns += other.overruns;
  missed_ticks += other.missed_ticks;
  fifo = fifo || other.fifo;
}

LoopQuality LoopQuality::Since(const LoopQuality& before) const {
  if (lateness.count() < before.lateness.count()) return *this;
  return {.lateness = lateness.Since(before.lateness),
          .actuation = actuation.Since(before.actuation),
          .overruns = overruns - before.overruns,
          .missed_ticks = missed_ticks - before.missed_ticks,
          .fifo = fifo};
}

}  // namespace faultlab::hardware
