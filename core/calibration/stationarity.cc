#include "core/calibration/stationarity.h"

#include <algorithm>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {

bool Stationarity::drifts() const {
  const double whole = change();
  for (std::size_t q = 1; q < shift.size(); ++q) {
    const double step = (shift[q] - shift[q - 1]) / whole;
    if (!(step > 0.1 && step < 0.6)) return false;  // each is about a third
  }
  return true;
}

Stationarity StationarityOf(const RigParameters& rig,
                            const NoiseLevel& noise,
                            double period_s,
                            std::span<const Observation> stretch,
                            std::size_t coordinates) {
  constexpr double kSmall = 1e-4;
  constexpr std::size_t kQuarters = Stationarity::kQuarters;
  InnovationTrace base;
  InnovationTrace moved;
  const InnovationSummary whole =
      RunInnovations(MakePredictionModel(rig, noise, period_s), stretch, &base);
  const std::size_t readings = base.whitened.size();
  const std::size_t quarter = (stretch.size() + kQuarters - 1) / kQuarters * kOutputCount;
  Stationarity found;
  for (std::size_t i = 0; i < coordinates; ++i) {
    ParameterOffsets q{};
    q[i] = kSmall;
    RunInnovations(
        MakePredictionModel(WithOffsets(rig, q, period_s), noise, period_s), stretch, &moved);
    std::array<double, kQuarters> cross{};
    std::array<double, kQuarters> square{};
    for (std::size_t r = 0; r < readings; ++r) {
      const double s = (moved.whitened[r] - base.whitened[r]) / kSmall;
      cross[r / quarter] += s * base.whitened[r];
      square[r / quarter] += s * s;
    }
    double score = 0.0;
    std::array<double, kQuarters> shift{};
    for (std::size_t b = 0; b < kQuarters; ++b) {
      if (!(square[b] > 0.0)) continue;
      score = std::max(score, cross[b] * cross[b] / square[b]);
      shift[b] = -cross[b] / square[b];
    }
    if (score <= found.score) continue;
    found.score = score;
    found.coordinate = static_cast<int>(i);
    found.shift = shift;
  }
  const double average = whole.chi2 / std::max(1, whole.count);
  for (std::size_t b = 0; b < kQuarters; ++b) {
    double chi2 = 0.0;
    const std::size_t begin = std::min(readings, b * quarter);
    const std::size_t end = std::min(readings, begin + quarter);
    for (std::size_t r = begin; r < end; ++r) chi2 += base.whitened[r] * base.whitened[r];
    const double share = static_cast<double>(end - begin) / static_cast<double>(readings);
    if (share > 0.0) found.energy = std::max(found.energy, chi2 / (share * whole.count * average));
  }
  return found;
}

}  // namespace faultlab::core
