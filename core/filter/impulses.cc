#include "core/filter/impulses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {
namespace {

constexpr double kFarthestShare = 0.02;

}  // namespace

std::size_t LeaveOutImpulses(const PredictionModel& model,
                             std::span<Observation> stretch,
                             const ImpulseRule& rule) {
  InnovationTrace trace;
  RunInnovations(model, stretch, &trace);
  std::size_t found = 0;
  std::array<double, kOutputCount> gate{};
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    const std::vector<double> sizes = SortedMagnitudes(trace, stretch, c);
    if (sizes.empty()) continue;
    gate[c] = rule.gate * RobustSigma(sizes);
    const auto most = std::max<std::size_t>(
        1, static_cast<std::size_t>(rule.share_max * static_cast<double>(sizes.size())));
    if (sizes[sizes.size() - 1 - most] > gate[c]) {
      if (!rule.or_the_farthest) return 0;
      const auto farthest =
          static_cast<std::size_t>(kFarthestShare * static_cast<double>(sizes.size()));
      gate[c] = sizes[sizes.size() - 1 - farthest];
    }
    found += static_cast<std::size_t>(sizes.end() -
                                      std::upper_bound(sizes.begin(), sizes.end(), gate[c]));
  }
  if (found == 0) return 0;
  for (std::size_t k = 0; k < stretch.size(); ++k) {
    Observation& o = stretch[k];
    for (std::size_t c = 0; c < kOutputCount; ++c) {
      if (((o.mask >> c) & 1U) == 0U) continue;
      if (std::abs(trace.whitened[k * kOutputCount + c]) <= gate[c]) continue;
      o.mask = static_cast<std::uint8_t>(o.mask & ~(1U << c));
      if (c == 0) o.clipped = 0;
    }
  }
  return found;
}

}  // namespace faultlab::core
