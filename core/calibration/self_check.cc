#include "core/calibration/self_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "core/calibration/switches.h"
#include "core/detection/detector.h"
#include "core/filter/step_age.h"
#include "core/types/check.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// The halves are quarters in turn, so that what changes along the stretch is in both.
constexpr std::size_t kQuarters = 4;
constexpr std::size_t kQuarterMin = 75;
// Steps of the input in each half.
constexpr int kHalfSwitchesMin = 3;
// Innovations are more than noise when their mean square, as their median tells it, is this many
// standard errors above 1, and by this factor.
constexpr double kGrowthErrors = 6.0;
constexpr double kGrowthLeast = 1.5;
constexpr double kGrowthReadingsMin = 6;
constexpr double kMedianOfSquares = 0.4549;  // of a standard normal variable
// Nothing is raised while all statistics stay below this share of their levels.
constexpr double kNear = 0.65;
// Of the largest statistic of the stretch by what was learnt from all of it.
constexpr double kOwnMargin = 1.5;
constexpr double kDayS = 86'400.0;
constexpr std::size_t kBlock = 100;  // samples at 100 Hz of which the largest statistics are taken
constexpr std::size_t kBlocksMin = 4;

constexpr std::size_t kWindows = 3;
constexpr std::size_t kDirections = ModelError::kDirections;
/// Residual squared, CUSUM, and the GLRs of three windows in each direction: the tail of each is
/// exponential.
constexpr std::size_t kStatistics = 2 + kWindows * kDirections;
using Statistics = std::array<double, kStatistics>;
/// Of a residual squared, the CUSUM, and the windows.
using Kinds = std::array<double, 2 + kWindows>;
// Nats by which a level grows while its rate falls by the factor e, of noise alone
// (detection_thresholds.cc).
constexpr Kinds kSlopes = {1.9, 1.0, 2.04, 2.15, 2.13};

constexpr std::size_t KindOf(std::size_t statistic) {
  return statistic < 2 ? statistic : 2 + (statistic - 2) / kDirections;
}

Statistics StatisticsOf(const Detector& detector) {
  const Detector::Statistics& s = detector.statistics();
  Statistics all{s.residual * s.residual, s.cusum};
  for (std::size_t w = 0; w < kWindows; ++w) {
    std::ranges::copy(detector.directions()[w],
                      all.begin() + 2 + static_cast<std::ptrdiff_t>(w * kDirections));
  }
  return all;
}

Kinds LevelsOf(const DetectionThresholds& t) {
  return {t.residual * t.residual, t.cusum, t.glr_short, t.glr_long, t.glr_slow};
}

/// Squares of innovations by channel and the samples since the last step of the input.
using Squares = std::array<std::array<std::vector<double>, ModelError::kAges>, kOutputCount>;

struct Maxima {
  std::vector<Statistics> of_blocks;
  Squares squares;
  Statistics of_block{};
  std::size_t in_block = 0;
};

void KeepMaxima(Detector& detector,
                std::span<const Observation> part,
                std::size_t block,
                double step_v,
                double period_s,
                Maxima& out) {
  StepAge age(period_s);
  for (const Observation& o : part) {
    (void)detector.Push(o);
    const std::size_t bin = age.Push(o.u - o.u_prev, step_v);
    for (std::size_t c = 0; c < kOutputCount; ++c) {
      const double z = detector.whitened()[c];
      if (z != 0.0) out.squares[c][bin].push_back(z * z);
    }
    const Statistics now = StatisticsOf(detector);
    for (std::size_t i = 0; i < kStatistics; ++i) {
      out.of_block[i] = std::max(out.of_block[i], now[i]);
    }
    if (++out.in_block < block) continue;
    out.of_blocks.push_back(out.of_block);
    out.of_block = {};
    out.in_block = 0;
  }
}

/// By the median: single readings that are far off say nothing.
/// @returns whether anything is more than noise
bool Grow(Squares& squares, ModelError& error) {
  bool any = false;
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    for (std::size_t age = 0; age < ModelError::kAges; ++age) {
      std::vector<double>& of = squares[c][age];
      const auto count = static_cast<double>(of.size());
      if (count < kGrowthReadingsMin) continue;
      std::ranges::nth_element(of, of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2));
      const double square = of[of.size() / 2] / kMedianOfSquares;
      if (square < std::max(kGrowthLeast, 1.0 + kGrowthErrors * std::sqrt(2.0 / count))) continue;
      error.growth[c][age] = std::sqrt(square);
      any = true;
    }
  }
  return any;
}

/// The level that the maxima of so many blocks a day pass at the stated rate.
double GumbelLevel(const std::vector<Statistics>& maxima,
                   std::size_t which,
                   double slope_min,
                   double nats) {
  const auto count = static_cast<double>(maxima.size());
  double sum = 0.0;
  double squares = 0.0;
  for (const Statistics& m : maxima) {
    sum += m[which];
    squares += m[which] * m[which];
  }
  const double mean = sum / count;
  const double variance = std::max(0.0, squares - count * mean * mean) / (count - 1.0);
  // One standard error of the slope is added: the level lies far beyond what has been seen.
  const double slope =
      std::sqrt(6.0 * variance) / std::numbers::pi * (1.0 + 1.0 / std::sqrt(count));
  const double used = std::max(slope_min, slope);
  return mean + used * (nats - std::numbers::egamma);
}

/// Quarters in turn, without the zeros of their channels.
std::array<std::vector<Observation>, 2> HalvesOf(std::span<const Observation> stretch,
                                                 const ReadingZeros& zeros) {
  std::array<std::vector<Observation>, 2> halves;
  const std::size_t quarter = stretch.size() / kQuarters;
  for (std::size_t k = 0; k < quarter * kQuarters; ++k) {
    Observation o = stretch[k];
    for (std::size_t c = 0; c < kOutputCount; ++c) o.y[c] -= zeros[c];
    o.restart = o.restart || k % quarter == 0;
    halves[k / quarter % 2].push_back(o);
  }
  return halves;
}

/// A filter that begins takes any reading.
void BeginWithoutImpulses(std::span<const Observation> without, std::span<Observation> as_read) {
  constexpr std::size_t kBeginning = 10;
  std::size_t since = kBeginning;
  for (std::size_t k = 0; k < as_read.size(); ++k) {
    since = as_read[k].restart ? 0 : since + 1;
    if (since < kBeginning) as_read[k].mask = without[k].mask;
  }
}

}  // namespace

std::optional<SelfCheck> CheckBySelf(const Calibration& calibration,
                                     const HealthyStretch& stretch,
                                     std::span<const Observation> as_read,
                                     const RigParameters& base,
                                     const Eigen::VectorXd& point,
                                     const NoiseLevel& noise,
                                     const GaussianPrior& prior) {
  LAB_CHECK(as_read.size() == stretch.samples.size(), as_read.size());
  if (stretch.samples.size() / kQuarters < kQuarterMin) return std::nullopt;
  const ReadingZeros zeros = RigAt(stretch, base, point).zeros;
  const std::array<std::vector<Observation>, 2> halves = HalvesOf(stretch.samples, zeros);
  std::vector<Observation> own(as_read.begin(), as_read.end());
  for (Observation& o : own) {
    for (std::size_t c = 0; c < kOutputCount; ++c) o.y[c] -= zeros[c];
  }
  for (const auto& half : halves) {
    if (SwitchesOf(half) < kHalfSwitchesMin) return std::nullopt;
  }

  const DetectionThresholds& noise_alone = calibration.thresholds;
  // A block holds a step of the input.
  const std::size_t block =
      std::max(SpanOf(kBlock, calibration.period_s),
               stretch.samples.size() / static_cast<std::size_t>(SwitchesOf(stretch.samples)));
  const double step_v = StepOf(stretch.samples);
  std::array<RigParameters, 2> rigs;
  for (std::size_t i = 0; i < halves.size(); ++i) {
    const HealthyStretch learnt{stretch.bench, stretch.period_s, halves[i], stretch.mask, {}};
    const MapFit fit = FitRig(learnt, base, noise, prior, point.head(prior.mean.size()));
    rigs[i] = RigAt(learnt, base, fit.point);
  }
  SelfCheck check;
  check.error = calibration.model_error;
  const auto detector_of = [&](const RigParameters& rig, std::size_t readings, NoiseScale scale) {
    return Detector(*stretch.bench,
                    rig,
                    DetectionNoiseOf(calibration),
                    calibration.period_s,
                    stretch.mask,
                    noise_alone,
                    static_cast<int>(readings),
                    scale,
                    0.0,
                    calibration.impulse_share > 0.0,
                    check.error);
  };
  const auto judge = [&] {
    Maxima maxima;
    std::array<std::vector<Observation>, 2> judged = HalvesOf(own, {});
    for (std::size_t i = 0; i < halves.size(); ++i) BeginWithoutImpulses(halves[i], judged[i]);
    for (std::size_t i = 0; i < halves.size(); ++i) {
      const std::size_t readings = halves[i].size();
      NoiseScale noise_scale(static_cast<int>(readings));
      maxima.of_block = {};
      maxima.in_block = 0;
      const std::span<const Observation> other(judged[1 - i]);
      const std::size_t quarter = other.size() / 2;
      for (const auto part : {other.first(quarter), other.last(quarter)}) {
        Detector detector = detector_of(rigs[i], readings, noise_scale);
        KeepMaxima(detector, part, block, step_v, stretch.period_s, maxima);
        noise_scale = detector.noise_scale();
      }
    }
    return maxima;
  };
  Maxima maxima = judge();
  if (maxima.of_blocks.size() < kBlocksMin) return std::nullopt;
  if (Grow(maxima.squares, check.error)) {
    check.error.step_v = step_v;
    GiveTrust(check.error, stretch.period_s, own);
    maxima = judge();
  }

  check.judged_s = static_cast<double>(2 * halves[0].size()) * calibration.period_s;
  const Kinds levels = LevelsOf(noise_alone);
  const double blocks_a_day = kDayS / (static_cast<double>(block) * calibration.period_s);
  const double nats = std::log(blocks_a_day * kStatistics / noise_alone.false_alarms_per_day);
  Statistics by{};
  bool near = check.error.any();
  for (std::size_t i = 0; i < kStatistics; ++i) {
    const std::size_t kind = KindOf(i);
    by[i] = 1.0;
    if (i == 0 && calibration.impulse_share > 0.0) continue;  // not in use
    for (const Statistics& m : maxima.of_blocks) near = near || m[i] > kNear * levels[kind];
    by[i] = std::max(1.0, GumbelLevel(maxima.of_blocks, i, kSlopes[kind], nats) / levels[kind]);
  }
  check.thresholds = noise_alone;
  if (!near) return check;
  // Nor does what was learnt from the whole raise an alarm in any of it.
  RigParameters whole = RigAt(stretch, base, point);
  whole.zeros = {};  // they are taken out here
  Maxima of_own;
  Detector detector = detector_of(whole, own.size(), NoiseScale(static_cast<int>(own.size())));
  KeepMaxima(detector, own, block, step_v, stretch.period_s, of_own);
  of_own.of_blocks.push_back(of_own.of_block);
  for (const Statistics& m : of_own.of_blocks) {
    for (std::size_t i = 0; i < kStatistics; ++i) {
      if (i == 0 && calibration.impulse_share > 0.0) continue;
      by[i] = std::max(by[i], kOwnMargin * m[i] / levels[KindOf(i)]);
    }
  }
  check.raised = std::ranges::max(by);
  check.thresholds.residual *= std::sqrt(by[0]);
  check.thresholds.cusum *= by[1];
  for (std::size_t i = 2; i < kStatistics; ++i) {
    check.error.raised[(i - 2) / kDirections][(i - 2) % kDirections] = by[i];
  }
  return check;
}

CalibrationCheck CheckOf(const SelfCheck& check) {
  std::array<char, 256> text{};
  const double shown = 3.0 * kDayS / check.judged_s;  // no event in T: fewer than 3 / T
  if (check.raised > 1.0) {
    std::snprintf(text.data(),
                  text.size(),
                  "the model leaves more than noise: alarm levels are up to %.1f times those of "
                  "noise alone, so that half of the stretch raises no alarm in the other half",
                  check.raised);
  } else {
    std::snprintf(
        text.data(),
        text.size(),
        "half of the stretch raises no alarm in the other half: in %.3g s that shows fewer "
        "than %.2g a day; the stated rate is that of noise alone",
        check.judged_s,
        shown);
  }
  return {"own stretch", text.data(), check.raised, 1.0, true};
}

}  // namespace faultlab::core
