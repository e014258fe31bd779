#include "core/calibration/stretch_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/calibration/bench_noise.h"
#include "core/calibration/switches.h"
#include "core/filter/innovation_filter.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// The description may be wrong about delta, and the first guess of the noise be far off, so the fit
// starts from several values, shares of the period.
constexpr std::array<double, 3> kDeltaStartShares = {0.95, 0.5, 0.1};
constexpr int kNoiseRounds = 3;
// A long stretch is searched through in its beginning, of so many samples at 100 Hz (SpanOf) and
// switches of the input at least, and fitted whole from what that has found.
constexpr std::size_t kPartSamples = 1000;
constexpr int kPartSwitches = 8;
// Noise of so many times the described one makes the search begin again, ..
constexpr double kMoreNoise = 1.5;
// .. with readings of so many times the described one.
constexpr double kNoisyReadings = 5.0;
// Friction noise cannot be estimated on every rig; a broad prior on its logarithm keeps the
// estimate bounded.
constexpr double kFrictionNoisePriorLogSd = 0.7;
// Lower bound of the reading noise as a share of the range: neither the converters (16 bit) nor the
// model are better.
constexpr double kNoiseFloorShare = 1e-5;
// The same of the speed: of the largest that it may start from.
constexpr double kNoiseFloorSpeedShare = 2e-5;

// Where a fit begins, and what it expects.
struct DeltaStart {
  double expected_s = 0.0;
  double first_s = 0.0;
};

std::vector<DeltaStart> DeltaStartsOf(const Bench& bench,
                                      double period_s,
                                      std::optional<double> expected_s) {
  if (expected_s) {
    const double within_s = std::min(*expected_s, kDeltaStartShares.front() * period_s);
    return {{within_s, within_s}};
  }
  std::vector<DeltaStart> starts;
  const double described_s =
      std::min(bench.ReadingDelay(bench.delta_s, period_s), kDeltaStartShares.front() * period_s);
  if (bench.fits_follow_noise) starts.push_back({described_s, described_s});
  for (const double share : kDeltaStartShares) {
    const double first_s = share * period_s;
    starts.push_back({bench.fits_follow_noise ? described_s : first_s, first_s});
  }
  return starts;
}

double* NoiseOfChannel(NoiseLevel& noise, std::size_t channel) {
  switch (channel) {
    case 0:
      return &noise.um_v;
    case 1:
      return &noise.ia_a;
    default:
      return &noise.w_rad_s;
  }
}

double FrictionPriorCost(const Bench& bench, const NoiseLevel& level) {
  const double off =
      std::log(level.friction_nm / bench.norm.friction_noise_nm) / kFrictionNoisePriorLogSd;
  return off * off;
}

// Maximum likelihood of the noise levels at fixed parameters: coordinate search in logarithms.
class NoiseFit {
 public:
  NoiseFit(const HealthyStretch& stretch, const RigParameters& rig)
      : stretch_(stretch),
        rig_(rig),
        floor_{kNoiseFloorShare * (stretch.bench->um.max - stretch.bench->um.min),
               kNoiseFloorShare * (stretch.bench->ia.max - stretch.bench->ia.min),
               kNoiseFloorSpeedShare * rig.plant.range.speed_rad_s,
               0.0} {}

  void Improve(NoiseLevel& noise) {
    best_ = CostsOf({noise, noise, noise, noise})[0];
    for (const double factor : {2.0, 1.4, 1.15, 1.05, 1.015}) {
      for (int pass = 0; pass < 4; ++pass) {
        bool improved = false;
        for (std::size_t c = 0; c <= kOutputCount; ++c) {
          if (c < kOutputCount && (stretch_.mask & (1U << c)) == 0U) continue;
          improved = Move(c, factor, noise) || improved;
        }
        if (!improved) break;
      }
    }
  }

 private:
  static constexpr std::size_t kTogether = 4;
  static constexpr int kStepsMax = 8;
  static constexpr double kGain = 1e-3;
  using Levels = std::array<NoiseLevel, kTogether>;

  // Computed side by side: four cost hardly more than one.
  std::array<double, kTogether> CostsOf(const Levels& levels) const {
    std::array<PredictionModel, kTogether> models;
    std::array<ModelSegment, kTogether> segments;
    std::array<ModelPath, kTogether> paths;
    std::array<InnovationSummary, kTogether> sums;
    std::array<double, kTogether> costs{};
    for (std::size_t i = 0; i < kTogether; ++i) {
      models[i] = MakePredictionModel(rig_, levels[i], stretch_.period_s);
      segments[i] = {0, &models[i]};
      paths[i] = ModelPath(&segments[i], 1);
    }
    RunInnovations(paths, stretch_.samples, sums);
    for (std::size_t i = 0; i < kTogether; ++i) {
      costs[i] = sums[i].cost() + FrictionPriorCost(*stretch_.bench, levels[i]);
    }
    return costs;
  }

  static double& Of(NoiseLevel& noise, std::size_t c) {
    return c < kOutputCount ? *NoiseOfChannel(noise, c) : noise.friction_nm;
  }

  // Upwards as far as the cost falls, or else downwards.
  bool Move(std::size_t c, double factor, NoiseLevel& noise) {
    Levels tried = {noise, noise, noise, noise};
    const std::array<double, 2> moves = {factor, 1.0 / factor};
    for (std::size_t way = 0; way < 2; ++way) {
      Of(tried[2 * way], c) *= moves[way];
      Of(tried[2 * way + 1], c) = Of(tried[2 * way], c) * moves[way];
    }
    const std::array<double, kTogether> costs = CostsOf(tried);
    for (std::size_t way = 0; way < 2; ++way) {
      if (!Takes(c, tried[2 * way], costs[2 * way], noise)) continue;
      if (!Takes(c, tried[2 * way + 1], costs[2 * way + 1], noise)) return true;
      for (int steps = 2; steps < kStepsMax; ++steps) {
        const int ahead = (steps - 2) % static_cast<int>(kTogether);
        if (ahead == 0) {
          for (std::size_t i = 0; i < kTogether; ++i) {
            tried[i] = i == 0 ? noise : tried[i - 1];
            Of(tried[i], c) *= moves[way];
          }
          ahead_ = CostsOf(tried);
        }
        const auto i = static_cast<std::size_t>(ahead);
        if (!Takes(c, tried[i], ahead_[i], noise)) return true;
      }
      return true;
    }
    return false;
  }

  bool Takes(std::size_t c, const NoiseLevel& tried, double cost, NoiseLevel& noise) {
    NoiseLevel level = tried;
    if (Of(level, c) < floor_[c] || cost >= best_ - kGain) return false;
    best_ = cost;
    noise = tried;
    return true;
  }

  const HealthyStretch& stretch_;
  const RigParameters& rig_;
  std::array<double, kOutputCount + 1> floor_;
  double best_ = 0.0;
  std::array<double, kTogether> ahead_{};
};

double SwingOf(std::span<const Observation> samples) {
  const auto [low, high] = std::ranges::minmax(samples, {}, &Observation::u);
  return high.u - low.u;
}

unsigned ReadIn(std::span<const Observation> samples) {
  unsigned mask = 0;
  for (const Observation& o : samples) mask |= o.mask;
  return mask;
}

// What is searched through first: all of a stretch that is not long, or whose beginning rests.
HealthyStretch PartOf(const HealthyStretch& stretch) {
  const std::size_t step = SpanOf(kPartSamples, stretch.period_s);
  HealthyStretch part = stretch;
  for (std::size_t n = step; n < stretch.samples.size(); n += step) {
    part.samples = stretch.samples.first(n);
    if (2.0 * SwingOf(part.samples) >= SwingOf(stretch.samples) &&
        SwitchesOf(part.samples) >= kPartSwitches && ReadIn(part.samples) == stretch.mask) {
      return part;
    }
  }
  return stretch;
}

Explained ExplainFrom(const HealthyStretch& stretch,
                      const RigParameters& data_sheet,
                      NoiseLevel noise,
                      const GaussianPrior& prior,
                      std::optional<double> expected_delta_s) {
  const double period_s = stretch.period_s;
  const HealthyStretch part = PartOf(stretch);
  Explained found;
  bool have = false;
  for (const DeltaStart& start : DeltaStartsOf(*stretch.bench, period_s, expected_delta_s)) {
    RigParameters started = data_sheet;
    started.delta_s = start.expected_s;
    Eigen::VectorXd point = Eigen::VectorXd::Zero(prior.mean.size());
    point(static_cast<int>(Coordinate::kDelta)) =
        (start.first_s - start.expected_s) / (kDeltaUnitPeriods * period_s);
    MapFit fit = FitRig(part, started, noise, prior, point);
    if (!have || fit.cost() < found.fit.cost()) {
      have = true;
      found.fit = fit;
      found.base = started;
    }
  }
  for (int round = 0; round < kNoiseRounds; ++round) {
    const HealthyStretch& of = round + 2 < kNoiseRounds ? part : stretch;
    NoiseFit(of, RigAt(stretch, found.base, found.fit.point)).Improve(noise);
    found.fit = FitRig(of, found.base, noise, prior, found.fit.point);
  }
  found.noise = noise;
  found.cost = found.fit.cost() + FrictionPriorCost(*stretch.bench, noise);
  return found;
}

}  // namespace

std::vector<ZeroCoordinate> ZerosToLearn(const Bench& bench, unsigned mask) {
  const std::array<double, kOutputCount> units = {
      bench.um.zero_sd,
      bench.ia.zero_sd,
      bench.n.zero_sd * RadPerSecondOfRpm(bench.nominal.gear_ratio)};
  std::vector<ZeroCoordinate> zeros;
  for (std::size_t c = 0; c < units.size(); ++c) {
    if (((mask >> c) & 1U) != 0U && units[c] > 0.0) zeros.push_back({c, units[c]});
  }
  return zeros;
}

RigParameters RigAt(const HealthyStretch& stretch,
                    const RigParameters& base,
                    const Eigen::VectorXd& point) {
  const Eigen::Index n = point.size() - static_cast<Eigen::Index>(stretch.zeros.size());
  RigParameters rig = WithOffsets(base, point.head(n), stretch.period_s);
  for (std::size_t i = 0; i < stretch.zeros.size(); ++i) {
    const ZeroCoordinate& zero = stretch.zeros[i];
    rig.zeros[zero.channel] = zero.unit * point(n + static_cast<Eigen::Index>(i));
  }
  return rig;
}

MapFit FitRig(const HealthyStretch& stretch,
              const RigParameters& base,
              const NoiseLevel& noise,
              const GaussianPrior& prior,
              const Eigen::VectorXd& start) {
  const StretchModels models{stretch.samples, [&](const Eigen::VectorXd& q, std::size_t) {
                               return MakePredictionModel(
                                   RigAt(stretch, base, q), noise, stretch.period_s);
                             }};
  MapFitOptions options;
  options.follow_noise = stretch.bench->fits_follow_noise;
  return FitMap(models, prior, start, options);
}

// Readings that are much noisier than the description says look like friction in the first fits,
// which may lead astray: then it begins again with noisy readings, which look like nothing else.
Explained ExplainStretch(const HealthyStretch& stretch,
                         const RigParameters& data_sheet,
                         const GaussianPrior& prior,
                         std::optional<double> expected_delta_s) {
  const NoiseLevel described = NoiseOf(*stretch.bench);
  Explained first = ExplainFrom(stretch, data_sheet, described, prior, expected_delta_s);
  bool more = first.noise.friction_nm > kMoreNoise * described.friction_nm;
  NoiseLevel noisy = described;
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if ((stretch.mask & (1U << c)) == 0U) continue;
    double& start = *NoiseOfChannel(noisy, c);
    const double found = *NoiseOfChannel(first.noise, c);
    more = more || found > kMoreNoise * start;
    start = std::max(kNoisyReadings * start, found);
  }
  if (!stretch.bench->fits_follow_noise || !more) return first;
  Explained second = ExplainFrom(stretch, data_sheet, noisy, prior, expected_delta_s);
  return second.cost < first.cost ? second : first;
}

}  // namespace faultlab::core
