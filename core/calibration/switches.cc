#include "core/calibration/switches.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {

int SwitchesOf(std::span<const Observation> stretch) {
  if (stretch.empty()) return 0;
  const auto [low, high] = std::ranges::minmax(stretch, {}, &Observation::u);
  const double swing = high.u - low.u;
  if (swing <= 0.0) return 0;
  const double least = 0.05 * swing;
  int steps = 0;
  double way = 0.0;
  double from = stretch.front().u;
  for (const Observation& o : stretch) {
    steps += std::abs(o.u - o.u_prev) > least;
    if (std::abs(o.u - from) <= least) continue;
    way += std::abs(o.u - from);
    from = o.u;
  }
  return std::max(steps, static_cast<int>(way / swing));
}

double StepOf(std::span<const Observation> stretch) {
  constexpr double kShare = 0.2;
  const auto [low, high] = std::ranges::minmax(stretch, {}, &Observation::u);
  return kShare * (high.u - low.u);
}

}  // namespace faultlab::core
