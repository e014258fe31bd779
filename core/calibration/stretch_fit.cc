#include "core/calibration/stretch_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/calibration/bench_noise.h"
#include "core/filter/innovation_filter.h"

namespace faultlab::core {
namespace {

// The description may be wrong about delta, and the first guess of the noise be far off, so the fit
// starts from several values, shares of the period.
constexpr std::array<double, 3> kDeltaStartShares = {0.95, 0.5, 0.1};
constexpr int kNoiseRounds = 3;
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
                                      std::optional<double> measured_s) {
  if (measured_s) {
    const double within_s = std::min(*measured_s, kDeltaStartShares.front() * period_s);
    return {{within_s, within_s}};
  }
  std::vector<DeltaStart> starts;
  const double described_s = std::min(bench.delta_s, kDeltaStartShares.front() * period_s);
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
void FitNoise(const Bench& bench,
              const RigParameters& rig,
              double period_s,
              std::span<const Observation> stretch,
              unsigned mask,
              NoiseLevel& noise) {
  const auto cost = [&](const NoiseLevel& level) {
    return RunInnovations(MakePredictionModel(rig, level, period_s), stretch).cost() +
           FrictionPriorCost(bench, level);
  };
  const std::array<double, kOutputCount> floor = {
      kNoiseFloorShare * (bench.um.max - bench.um.min),
      kNoiseFloorShare * (bench.ia.max - bench.ia.min),
      kNoiseFloorSpeedShare * rig.plant.range.speed_rad_s};
  double best = cost(noise);
  for (double factor : {2.0, 1.4, 1.15, 1.05, 1.015}) {
    for (int pass = 0; pass < 4; ++pass) {
      bool improved = false;
      for (std::size_t c = 0; c <= kOutputCount; ++c) {
        if (c < kOutputCount && (mask & (1U << c)) == 0U) continue;
        for (double move : {factor, 1.0 / factor}) {
          for (int repeat = 0; repeat < 8; ++repeat) {
            NoiseLevel tried = noise;
            double* value = c < kOutputCount ? NoiseOfChannel(tried, c) : &tried.friction_nm;
            *value *= move;
            if (c < kOutputCount && *value < floor[c]) break;
            const double tried_cost = cost(tried);
            if (tried_cost >= best - 1e-3) break;
            best = tried_cost;
            noise = tried;
            improved = true;
          }
        }
      }
      if (!improved) break;
    }
  }
}

Explained ExplainFrom(const Bench& bench,
                      const RigParameters& data_sheet,
                      NoiseLevel noise,
                      double period_s,
                      std::span<const Observation> stretch,
                      unsigned mask,
                      const GaussianPrior& prior,
                      std::optional<double> measured_delta_s) {
  Explained found;
  bool have = false;
  for (const DeltaStart& start : DeltaStartsOf(bench, period_s, measured_delta_s)) {
    RigParameters started = data_sheet;
    started.delta_s = start.expected_s;
    Eigen::VectorXd point = Eigen::VectorXd::Zero(prior.mean.size());
    point(static_cast<int>(Coordinate::kDelta)) =
        (start.first_s - start.expected_s) / (kDeltaUnitPeriods * period_s);
    MapFit fit = FitRig(bench, started, noise, period_s, stretch, prior, point);
    if (!have || fit.cost() < found.fit.cost()) {
      have = true;
      found.fit = fit;
      found.base = started;
    }
  }
  for (int round = 0; round < kNoiseRounds; ++round) {
    const RigParameters rig = RigAt(bench, found.base, found.fit.point, period_s);
    FitNoise(bench, rig, period_s, stretch, mask, noise);
    found.fit = FitRig(bench, found.base, noise, period_s, stretch, prior, found.fit.point);
  }
  found.noise = noise;
  found.cost = found.fit.cost() + FrictionPriorCost(bench, noise);
  return found;
}

}  // namespace

std::array<double, kOutputCount> ZeroUnitsOf(const Bench& bench) {
  return {bench.um.zero_sd,
          bench.ia.zero_sd,
          bench.n.zero_sd * RadPerSecondOfRpm(bench.nominal.gear_ratio)};
}

RigParameters RigAt(const Bench& bench,
                    const RigParameters& base,
                    const Eigen::VectorXd& point,
                    double period_s) {
  RigParameters rig = WithOffsets(base, point.head(point.size() - kOutputCount), period_s);
  const std::array<double, kOutputCount> units = ZeroUnitsOf(bench);
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    rig.zeros[c] = units[c] * point.tail<kOutputCount>()(static_cast<Eigen::Index>(c));
  }
  return rig;
}

MapFit FitRig(const Bench& bench,
              const RigParameters& base,
              const NoiseLevel& noise,
              double period_s,
              std::span<const Observation> stretch,
              const GaussianPrior& prior,
              const Eigen::VectorXd& start) {
  const StretchModels models{stretch, [&](const Eigen::VectorXd& q, std::size_t) {
                               return MakePredictionModel(
                                   RigAt(bench, base, q, period_s), noise, period_s);
                             }};
  MapFitOptions options;
  options.follow_noise = bench.fits_follow_noise;
  return FitMap(models, prior, start, options);
}

// Readings that are much noisier than the description says look like friction in the first fits,
// which may lead astray: then it begins again with noisy readings, which look like nothing else.
Explained ExplainStretch(const Bench& bench,
                         const RigParameters& data_sheet,
                         double period_s,
                         std::span<const Observation> stretch,
                         unsigned mask,
                         const GaussianPrior& prior,
                         std::optional<double> measured_delta_s) {
  const NoiseLevel described = NoiseOf(bench);
  Explained first =
      ExplainFrom(bench, data_sheet, described, period_s, stretch, mask, prior, measured_delta_s);
  bool more = first.noise.friction_nm > kMoreNoise * described.friction_nm;
  NoiseLevel noisy = described;
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if ((mask & (1U << c)) == 0U) continue;
    double& start = *NoiseOfChannel(noisy, c);
    const double found = *NoiseOfChannel(first.noise, c);
    more = more || found > kMoreNoise * start;
    start = std::max(kNoisyReadings * start, found);
  }
  if (!bench.fits_follow_noise || !more) return first;
  Explained second =
      ExplainFrom(bench, data_sheet, noisy, period_s, stretch, mask, prior, measured_delta_s);
  return second.cost < first.cost ? second : first;
}

}  // namespace faultlab::core
