#include "core/calibration/self_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "core/calibration/switches.h"
#include "core/detection/detector.h"
#include "core/types/check.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// The halves are quarters in turn, so that what changes along the stretch is in both.
constexpr std::size_t kQuarters = 4;
constexpr std::size_t kQuarterMin = 75;
// Steps of the input in each half: as many as a calibration needs.
constexpr int kHalfSwitchesMin = 8;
// Nothing is raised while all statistics stay below this share of their levels.
constexpr double kNear = 0.65;
constexpr double kDayS = 86'400.0;
constexpr std::size_t kBlock = 100;  // samples at 100 Hz of which the largest statistics are taken
constexpr std::size_t kBlocksMin = 4;

/// Residual squared, CUSUM, and the GLRs of three windows: the tail of each is exponential.
constexpr std::size_t kStatistics = 5;
using Statistics = std::array<double, kStatistics>;
// Nats by which a level grows while its rate falls by the factor e, of noise alone
// (detection_thresholds.cc).
constexpr Statistics kSlopes = {1.9, 1.0, 2.04, 2.15, 2.13};

Statistics StatisticsOf(const Detector::Statistics& s) {
  return {s.residual * s.residual, s.cusum, s.glr_short, s.glr_long, s.glr_slow};
}

Statistics LevelsOf(const DetectionThresholds& t) {
  return {t.residual * t.residual, t.cusum, t.glr_short, t.glr_long, t.glr_slow};
}

DetectionThresholds WithLevels(DetectionThresholds t, const Statistics& levels) {
  t.residual = std::sqrt(levels[0]);
  t.cusum = levels[1];
  t.glr_short = levels[2];
  t.glr_long = levels[3];
  t.glr_slow = levels[4];
  return t;
}

struct Maxima {
  std::vector<Statistics> of_blocks;
  bool rows = false;  ///< SelfCheck::rows
  Statistics of_block{};
  std::size_t in_block = 0;
};

void KeepMaxima(Detector& detector,
                std::span<const Observation> part,
                std::size_t block,
                Maxima& out) {
  for (const Observation& o : part) {
    (void)detector.Push(o);
    const Statistics now = StatisticsOf(detector.statistics());
    for (std::size_t i = 0; i < kStatistics; ++i) {
      out.of_block[i] = std::max(out.of_block[i], now[i]);
    }
    out.rows = out.rows || detector.statistics().far_off > 1.0;
    if (++out.in_block < block) continue;
    out.of_blocks.push_back(out.of_block);
    out.of_block = {};
    out.in_block = 0;
  }
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
  std::array<std::vector<Observation>, 2> judged = HalvesOf(as_read, zeros);
  for (std::size_t i = 0; i < halves.size(); ++i) BeginWithoutImpulses(halves[i], judged[i]);
  for (const auto& half : halves) {
    if (SwitchesOf(half) < kHalfSwitchesMin) return std::nullopt;
  }

  const DetectionThresholds& noise_alone = calibration.thresholds;
  const std::size_t block = SpanOf(kBlock, calibration.period_s);
  Maxima maxima;
  for (std::size_t i = 0; i < halves.size(); ++i) {
    const HealthyStretch learnt{stretch.bench, stretch.period_s, halves[i], stretch.mask, {}};
    const MapFit fit = FitRig(learnt, base, noise, prior, point.head(prior.mean.size()));
    const auto readings = static_cast<int>(halves[i].size());
    const RigParameters rig = RigAt(learnt, base, fit.point);
    NoiseScale noise_scale(readings);
    maxima.of_block = {};
    maxima.in_block = 0;
    const std::span<const Observation> other(judged[1 - i]);
    const std::size_t quarter = other.size() / 2;
    for (const auto part : {other.first(quarter), other.last(quarter)}) {
      Detector detector(*stretch.bench,
                        rig,
                        DetectionNoiseOf(calibration),
                        calibration.period_s,
                        stretch.mask,
                        noise_alone,
                        readings,
                        noise_scale,
                        0.0,
                        calibration.impulse_share > 0.0);
      KeepMaxima(detector, part, block, maxima);
      noise_scale = detector.noise_scale();
    }
  }
  if (maxima.of_blocks.size() < kBlocksMin) return std::nullopt;

  SelfCheck check;
  check.rows = maxima.rows;
  check.judged_s = static_cast<double>(2 * halves[0].size()) * calibration.period_s;
  const Statistics levels = LevelsOf(noise_alone);
  const double blocks_a_day = kDayS / (static_cast<double>(block) * calibration.period_s);
  const double nats = std::log(blocks_a_day * kStatistics / noise_alone.false_alarms_per_day);
  Statistics raised = levels;
  bool near = false;
  for (std::size_t i = 0; i < kStatistics; ++i) {
    if (i == 0 && calibration.impulse_share > 0.0) continue;  // not in use
    for (const Statistics& m : maxima.of_blocks) near = near || m[i] > kNear * levels[i];
    raised[i] = std::max(levels[i], GumbelLevel(maxima.of_blocks, i, kSlopes[i], nats));
  }
  check.thresholds = near ? WithLevels(noise_alone, raised) : noise_alone;
  for (std::size_t i = 0; near && i < kStatistics; ++i) {
    check.raised = std::max(check.raised, raised[i] / levels[i]);
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
