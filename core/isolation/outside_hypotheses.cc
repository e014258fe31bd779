#include "core/isolation/outside_hypotheses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/filter/innovation_filter.h"
#include "core/isolation/hypothesis.h"

namespace faultlab::core {
namespace {

// Standard deviation of a change before anything is known: a factor of e in the gain, as much as
// the channel moves in use in the zero, and ten times what it was in the friction.
constexpr double kPriorSd = 1.0;
constexpr double kFrictionPriorSd = 10.0;
constexpr std::size_t kFitted = 3;
constexpr double kStep = 1e-5;
constexpr double kGainMin = 0.02;  // of 1 / gain, where the search for it begins

constexpr std::array<std::string_view, kOutputCount> kChannels = {"um", "ia", "n"};

/// One change that is tried. Its coordinate counts in units: of a zero the channel's spread, of
/// friction what it was, or what a description is sure of.
struct Trial {
  enum class Of { kZero, kGain, kFriction };
  Of of = Of::kZero;
  std::size_t channel = 0;  ///< of a zero or a gain
  double unit = 1.0;
  double held_cost = 0.0;  ///< with the other coordinates held
  double start = 0.0;

  double prior_sd() const { return of == Of::kFriction ? kFrictionPriorSd : kPriorSd; }
};

RigParameters Changed(const RigParameters& rig, const Trial& trial, double q) {
  RigParameters changed = rig;
  switch (trial.of) {
    case Trial::Of::kZero:
      changed.zeros[trial.channel] += q * trial.unit;
      break;
    case Trial::Of::kGain:
      changed.scales[trial.channel] *= std::exp(-q);
      break;
    case Trial::Of::kFriction:
      changed.mc_nm += q * trial.unit;
      break;
  }
  return changed;
}

/// The readings of one channel.
struct Readings {
  double count = 0.0;
  double sum = 0.0;
  double square = 0.0;

  double Mean() const { return sum / count; }
  double Spread() const { return std::sqrt(std::max(0.0, square / count - Mean() * Mean())); }
};
using AllReadings = std::array<Readings, kOutputCount>;

AllReadings ReadingsOf(std::span<const Observation> stretch) {
  AllReadings all;
  for (const Observation& o : stretch) {
    for (std::size_t c = 0; c < kOutputCount; ++c) {
      if (((o.mask >> c) & 1U) == 0U) continue;
      all[c].count += 1.0;
      all[c].sum += o.y[c];
      all[c].square += o.y[c] * o.y[c];
    }
  }
  return all;
}

std::vector<Trial> TrialsOf(const FitContext& context, const AllReadings& readings) {
  std::vector<Trial> trials;
  trials.push_back({Trial::Of::kFriction, 0, std::max(context.rig.mc_nm, context.rig.mc_unit_nm)});
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if (!(readings[c].count > 1.0) || !(readings[c].Spread() > 0.0)) continue;
    trials.push_back({Trial::Of::kZero, c, readings[c].Spread()});
    trials.push_back({Trial::Of::kGain, c, 1.0});
  }
  return trials;
}

void TryHeld(const FitContext& context, std::vector<Trial>& trials) {
  const std::size_t n = trials.size();
  std::vector<PredictionModel> models;
  for (const Trial& trial : trials) {
    models.push_back(context.ModelOf(Changed(context.rig, trial, kStep)));
  }
  models.push_back(context.ModelOf(context.rig));
  std::vector<ModelSegment> segments(n + 1);
  std::vector<ModelPath> paths(n + 1);
  for (std::size_t i = 0; i <= n; ++i) {
    segments[i] = {0, &models[i]};
    paths[i] = ModelPath(&segments[i], 1);
  }
  std::vector<InnovationSummary> sums(n + 1);
  InnovationTable table;
  RunInnovations(paths, context.stretch, sums, &table);
  const auto nominal = table.col(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::VectorXd s = (table.col(static_cast<Eigen::Index>(i)) - nominal) / kStep;
    const double cross = s.dot(nominal);
    const double information =
        s.squaredNorm() + 1.0 / (trials[i].prior_sd() * trials[i].prior_sd());
    trials[i].start = -cross / information;
    if (trials[i].of == Trial::Of::kGain)
      trials[i].start = -std::log(std::max(1.0 - trials[i].start, kGainMin));
    trials[i].held_cost = sums[n].cost() - cross * cross / information;
  }
}

OutsideFit FitTrial(const FitContext& context, const Trial& trial) {
  const Eigen::Index n = context.coordinates();
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(1 + n);
  prior.mean.tail(n) = context.calibration.mean;
  prior.information = Eigen::MatrixXd::Zero(1 + n, 1 + n);
  prior.information(0, 0) = 1.0 / (trial.prior_sd() * trial.prior_sd());
  prior.information.bottomRightCorner(n, n) = context.calibration.information;
  const StretchModels models{context.stretch, [&](const Eigen::VectorXd& q, std::size_t) {
                               const RigParameters rig = context.RigAt(q.tail(n));
                               return context.ModelOf(Changed(rig, trial, q(0)));
                             }};
  Eigen::VectorXd start = prior.mean;
  start(0) = trial.start;
  const MapFit fit = FitMap(models, prior, start, context.FitOptions());
  OutsideFit found;
  found.cost = fit.cost();
  found.chi2 = fit.innovations.chi2;
  found.count = fit.innovations.count;
  const double sd = std::sqrt(std::max(0.0, fit.covariance(0, 0)));
  found.evidence = found.cost - 2.0 * std::log(kValueLogSd * std::max(sd, 1e-9) / trial.prior_sd());
  if (trial.of == Trial::Of::kFriction) {
    // Two coordinates move it: the change, and what calibration left unknown.
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(1 + n);
    slope(0) = trial.unit;
    slope(1 + static_cast<Eigen::Index>(Coordinate::kMc)) = context.rig.mc_unit_nm;
    found.friction = {context.RigAt(context.calibration.mean).mc_nm,
                      Changed(context.RigAt(fit.point.tail(n)), trial, fit.point(0)).mc_nm,
                      std::sqrt(std::max(0.0, slope.dot(fit.covariance * slope)))};
    return found;
  }
  const bool gain = trial.of == Trial::Of::kGain;
  SensorChange change;
  change.channel = kChannels[trial.channel];
  change.kind = gain ? SensorChange::Kind::kGain : SensorChange::Kind::kZero;
  // A speed is given as it is read, in rpm behind the gear.
  const double per_unit =
      trial.channel == 2 ? RadPerSecondOfRpm(context.rig.plant.gear_ratio) : 1.0;
  change.value = gain ? std::exp(fit.point(0)) : fit.point(0) * trial.unit / per_unit;
  change.sigma = gain ? change.value * sd : sd * trial.unit / per_unit;
  found.sensor = std::move(change);
  return found;
}

/// The channel's readings have nothing to do with the rig, which is as it was: they are normal
/// values around a mean of their own, of a spread of their own that is no smaller than the noise.
class LostSensor {
 public:
  LostSensor(const FitContext& context, std::size_t channel, const Readings& readings)
      : channel_(channel),
        others_(context.stretch.begin(), context.stretch.end()),
        without_(context) {
    for (Observation& o : others_) {
      o.mask = static_cast<std::uint8_t>(o.mask & ~(1U << channel));
      if (channel == 0) o.clipped = 0;
    }
    without_.stretch = others_;
    const std::array<double, kOutputCount> noise = {
        context.noise.um_v, context.noise.ia_a, context.noise.w_rad_s};
    const double square = readings.Spread() * readings.Spread();
    const double variance = std::max(square, noise[channel] * noise[channel]);
    // The mean and the spread cost a parameter each (BIC).
    own_cost_ =
        readings.count * (square / variance + std::log(variance)) + 2.0 * std::log(readings.count);
  }

  /// With the other coordinates held.
  double HeldCost() const {
    return own_cost_ + RunInnovations(without_.ModelOf(without_.rig), others_).cost();
  }

  OutsideFit Fit() const {
    const HypothesisFit fit = FitNullHypothesis(without_);
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {SensorChange{std::string(kChannels[channel_]), SensorChange::Kind::kLost, kNone, kNone},
            std::nullopt,
            own_cost_ + fit.cost,
            own_cost_ + fit.cost,
            fit.chi2,
            fit.count};
  }

 private:
  std::size_t channel_;
  std::vector<Observation> others_;
  FitContext without_;  ///< with the stretch of the others
  double own_cost_ = 0.0;
};

}  // namespace

std::optional<OutsideFit> BestOutside(const FitContext& context, double worth_cost, bool turns) {
  const AllReadings readings = ReadingsOf(context.stretch);
  const auto is_read = [](const Readings& of) { return of.count > 1.0; };
  if (std::ranges::count_if(readings, is_read) < 2) return std::nullopt;
  std::vector<Trial> trials = turns ? TrialsOf(context, readings) : std::vector<Trial>{};
  if (turns) TryHeld(context, trials);
  std::sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
    return a.held_cost < b.held_cost;
  });
  std::optional<OutsideFit> best;
  const auto take = [&best](OutsideFit fit) {
    if (fit.friction && fit.friction->after_nm < 0.0) return;  // there is no such friction
    if (!best || fit.cost < best->cost) best = std::move(fit);
  };
  for (std::size_t i = 0; i < std::min(kFitted, trials.size()); ++i) {
    if (!(trials[i].held_cost < worth_cost)) break;
    take(FitTrial(context, trials[i]));
  }
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if (!is_read(readings[c])) continue;
    const LostSensor lost(context, c, readings[c]);
    if (lost.HeldCost() < worth_cost) take(lost.Fit());
  }
  return best;
}

}  // namespace faultlab::core
