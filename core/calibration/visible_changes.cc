#include "core/calibration/visible_changes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "core/detection/detector.h"
#include "core/detection/directions.h"
#include "core/filter/innovation_filter.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

constexpr double kStep = 1e-4;
// Of the windows, so many hold more information: the next such window comes soon.
constexpr double kBestShare = 0.1;
// A change by more than this factor, e^q, is not told: the linear response says nothing of it.
constexpr double kLargest = 1.0;

struct Window {
  std::size_t samples = 0;
  double level = 0.0;
};

/// s^2 of a sample, summed from the beginning.
std::vector<double> Information(const InnovationTrace& base, const InnovationTrace& moved) {
  const std::size_t samples = base.whitened.size() / kOutputCount;
  std::vector<double> sums(samples + 1);
  for (std::size_t k = 0; k < samples; ++k) {
    double squares = 0.0;
    for (std::size_t at = k * kOutputCount; at < (k + 1) * kOutputCount; ++at) {
      const double s = (moved.whitened[at] - base.whitened[at]) / kStep;
      squares += s * s;
    }
    sums[k + 1] = sums[k] + squares;
  }
  return sums;
}

/// @param walk  how far the quantity wanders without a fault
double SmallestChange(const std::vector<double>& sums, const Window& window, double walk) {
  const std::size_t samples = sums.size() - 1;
  if (samples < window.samples) return std::numeric_limits<double>::infinity();
  std::vector<double> windows;
  for (std::size_t k = window.samples; k <= samples; ++k) {
    windows.push_back(sums[k] - sums[k - window.samples]);
  }
  const auto best =
      windows.begin() +
      static_cast<std::ptrdiff_t>((1.0 - kBestShare) * static_cast<double>(windows.size() - 1));
  std::nth_element(windows.begin(), best, windows.end());
  const double used = 1.0 + static_cast<double>(window.samples) / static_cast<double>(samples);
  return *best > 0.0 ? std::sqrt(window.level * used * (1.0 / *best + walk * walk))
                     : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<VisibleChange> VisibleChanges(const HealthyStretch& stretch,
                                          const RigParameters& rig,
                                          const NoiseLevel& noise,
                                          const DetectionThresholds& thresholds,
                                          const ModelError& error) {
  const double period_s = stretch.period_s;
  // A sum that forgets over n samples weighs as much as a window of 2 n.
  const std::array<Window, 3> windows = {
      {{SpanOf(Detector::kShort, period_s), thresholds.glr_short},
       {SpanOf(Detector::kLong, period_s), thresholds.glr_long},
       {2 * SpanOf(Detector::kSlow, period_s), thresholds.glr_slow}}};
  InnovationTrace base;
  RunInnovations(MakePredictionModel(rig, noise, period_s), stretch.samples, &base);
  std::vector<VisibleChange> told;
  std::array<bool, kCoordinateMax> done{};
  for (const ComponentInfo& part : stretch.bench->parts) {
    const int coordinate = CoordinateOf(part, rig.plant);
    if (coordinate < 0 || done[static_cast<std::size_t>(coordinate)]) continue;
    done[static_cast<std::size_t>(coordinate)] = true;
    ParameterOffsets q{};
    q[static_cast<std::size_t>(coordinate)] = kStep;
    InnovationTrace moved;
    RunInnovations(MakePredictionModel(WithOffsets(rig, q, period_s), noise, period_s),
                   stretch.samples,
                   &moved);
    const std::vector<double> sums = Information(base, moved);
    const double walk = WalkOf(error)[static_cast<std::size_t>(coordinate)];
    double least = std::numeric_limits<double>::infinity();
    const int direction = DirectionOf(*stretch.bench, static_cast<Coordinate>(coordinate));
    for (std::size_t w = 0; w < windows.size(); ++w) {
      Window window = windows[w];
      if (direction >= 0) window.level *= error.raised[w][static_cast<std::size_t>(direction)];
      least = std::min(least, SmallestChange(sums, window, walk));
    }
    if (!std::isfinite(least)) continue;
    const bool gain = coordinate == static_cast<int>(Coordinate::kGain);
    told.push_back(
        {gain ? "k" : part.symbol,
         least <= kLargest ? std::expm1(least) : std::numeric_limits<double>::infinity()});
  }
  return told;
}

std::string TextOf(std::span<const VisibleChange> changes) {
  std::string told;
  for (const VisibleChange& change : changes) {
    std::array<char, 64> text{};
    if (std::isfinite(change.share)) {
      std::snprintf(
          text.data(), text.size(), "%s from %.2g %%", change.symbol.c_str(), 100.0 * change.share);
    } else {
      std::snprintf(
          text.data(), text.size(), "%s only when it more than doubles", change.symbol.c_str());
    }
    told += (told.empty() ? "" : ", ") + std::string(text.data());
  }
  return told;
}

std::vector<VisibleChange> VisibleUnder(const Bench& bench,
                                        const Calibration& calibration,
                                        std::span<const Sample> samples,
                                        Channels channels,
                                        double um_rail_v) {
  const std::vector<Observation> observations = MakeObservations(
      samples, bench.readings(), channels, calibration.period_s, um_rail_v, ErrorsOf(calibration));
  HealthyStretch stretch;
  stretch.bench = &bench;
  stretch.period_s = calibration.period_s;
  stretch.samples = observations;
  stretch.mask = calibration.mask();
  return VisibleChanges(stretch,
                        ParametersOf(calibration),
                        NoiseOf(calibration),
                        calibration.thresholds,
                        calibration.model_error);
}

}  // namespace faultlab::core
