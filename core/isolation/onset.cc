#include "core/isolation/onset.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {
namespace {

// Number of faulty samples after the latest candidate; every candidate must explain them.
constexpr std::size_t kTail = 20;

}  // namespace

std::size_t EstimateOnset(const RigParameters& before,
                          const RigParameters& after,
                          const NoiseLevel& noise,
                          double period_s,
                          bool uncharged,
                          std::span<const Observation> stretch,
                          std::size_t last) {
  const PredictionModel healthy = MakePredictionModel(before, noise, period_s);
  const PredictionModel faulty = MakePredictionModel(after, noise, period_s);
  const auto span = stretch.first(std::min(stretch.size(), last + kTail));
  const std::size_t candidates = span.empty() ? 0 : std::min(last, span.size() - 1);
  if (candidates == 0) return last;
  std::vector<std::array<ModelSegment, 2>> segments(candidates);
  std::vector<ModelPath> paths(candidates);
  for (std::size_t i = 0; i < candidates; ++i) {
    segments[i] = {{{0, &healthy}, {i + 1, &faulty, uncharged}}};
    paths[i] = segments[i];
  }
  std::vector<InnovationSummary> sums(candidates);
  RunInnovations(paths, span, sums);
  std::size_t best = last;
  double best_chi2 = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < candidates; ++i) {
    if (!(sums[i].chi2 < best_chi2)) continue;
    best_chi2 = sums[i].chi2;
    best = i + 1;
  }
  return best;
}

}  // namespace faultlab::core
