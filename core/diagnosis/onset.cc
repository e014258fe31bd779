#include "core/diagnosis/onset.h"

#include <algorithm>
#include <array>
#include <limits>

namespace faultlab::core {
namespace {

// Faulty samples behind the latest candidate that every candidate must explain.
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
  std::size_t best = last;
  double best_chi2 = std::numeric_limits<double>::max();
  for (std::size_t onset = 1; onset <= last && onset < span.size(); ++onset) {
    const std::array<ModelSegment, 2> segments = {{{0, &healthy}, {onset, &faulty, uncharged}}};
    const double chi2 = RunInnovations(segments, span).chi2;
    if (chi2 < best_chi2) {
      best_chi2 = chi2;
      best = onset;
    }
  }
  return best;
}

}  // namespace faultlab::core
