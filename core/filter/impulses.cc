#include "core/filter/impulses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {
namespace {

// Of normal values: their standard deviation over the median of their magnitudes.
constexpr double kPerMedian = 1.4826;
constexpr double kShareMax = 0.05;

}  // namespace

std::size_t LeaveOutImpulses(const PredictionModel& model, std::span<Observation> stretch) {
  InnovationTrace trace;
  RunInnovations(model, stretch, &trace);
  std::size_t readings = 0;
  std::size_t found = 0;
  std::array<double, kOutputCount> gate{};
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    std::vector<double> sizes;
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      if (((stretch[k].mask >> c) & 1U) == 0U) continue;
      sizes.push_back(std::abs(trace.whitened[k * kOutputCount + c]));
    }
    if (sizes.empty()) continue;
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    gate[c] = kImpulseGate * kPerMedian * *middle;
    readings += sizes.size();
    found += static_cast<std::size_t>(
        std::count_if(sizes.begin(), sizes.end(), [&](double size) { return size > gate[c]; }));
  }
  if (found == 0 || static_cast<double>(found) > kShareMax * static_cast<double>(readings)) {
    return 0;
  }
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
