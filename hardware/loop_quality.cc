#include "hardware/loop_quality.h"

#include <algorithm>
#include <limits>

namespace faultlab::hardware {

void LoopQuality::Count(double lateness_s) {
  const double lateness_us = lateness_s * 1e6;
  std::size_t bucket = 0;
  while (bucket < kBoundsUs.size() && lateness_us > static_cast<double>(kBoundsUs[bucket])) {
    ++bucket;
  }
  ++lateness[bucket];
  ++ticks;
  lateness_sum_s += lateness_s;
  lateness_worst_s = std::max(lateness_worst_s, lateness_s);
}

double LoopQuality::QuantileBound(double q) const {
  const double wanted = q * static_cast<double>(ticks);
  double seen = 0.0;
  for (std::size_t bucket = 0; bucket < kBoundsUs.size(); ++bucket) {
    seen += static_cast<double>(lateness[bucket]);
    if (seen >= wanted) return static_cast<double>(kBoundsUs[bucket]) * 1e-6;
  }
  return std::numeric_limits<double>::infinity();
}

LoopQuality LoopQuality::Since(const LoopQuality& before) const {
  LoopQuality run = *this;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    run.lateness[bucket] -= before.lateness[bucket];
  }
  run.ticks -= before.ticks;
  run.overruns -= before.overruns;
  run.missed_ticks -= before.missed_ticks;
  run.lateness_sum_s -= before.lateness_sum_s;
  return run;
}

}  // namespace faultlab::hardware
