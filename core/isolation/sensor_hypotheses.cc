#include "core/isolation/sensor_hypotheses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {
namespace {

// Standard deviation of a change before anything is known, which keeps fits regular: a factor of e
// in the gain, and as much as the channel moves in use in the zero.
constexpr double kPriorSd = 1.0;
constexpr std::size_t kFitted = 2;
constexpr double kStep = 1e-5;

/// One change that is tried. The coordinate of a zero counts in units of the channel's spread.
struct Trial {
  std::size_t channel = 0;
  bool gain = false;
  double unit = 1.0;
  double held_cost = 0.0;  ///< with the other coordinates held
  double start = 0.0;
};

RigParameters Changed(const RigParameters& rig, const Trial& trial, double q) {
  RigParameters changed = rig;
  if (trial.gain) {
    changed.scales[trial.channel] *= std::exp(-q);
  } else {
    changed.zeros[trial.channel] += q * trial.unit;
  }
  return changed;
}

std::vector<Trial> TrialsOf(const FitContext& context) {
  std::array<double, kOutputCount> sum{};
  std::array<double, kOutputCount> square{};
  std::array<double, kOutputCount> count{};
  for (const Observation& o : context.stretch) {
    for (std::size_t c = 0; c < kOutputCount; ++c) {
      if (((o.mask >> c) & 1U) == 0U) continue;
      sum[c] += o.y[c];
      square[c] += o.y[c] * o.y[c];
      count[c] += 1.0;
    }
  }
  const auto read = std::count_if(count.begin(), count.end(), [](double n) { return n > 1.0; });
  std::vector<Trial> trials;
  if (read < 2) return trials;
  for (std::size_t c = 0; c < kOutputCount; ++c) {
    if (!(count[c] > 1.0)) continue;
    const double mean = sum[c] / count[c];
    const double spread = std::sqrt(std::max(0.0, square[c] / count[c] - mean * mean));
    if (!(spread > 0.0)) continue;
    trials.push_back({c, false, spread});
    trials.push_back({c, true, 1.0});
  }
  return trials;
}

/// Fills held_cost and start: the minimum over q of |z + q s|^2 + (q / sd)^2.
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
    const double information = s.squaredNorm() + 1.0 / (kPriorSd * kPriorSd);
    trials[i].start = -cross / information;
    trials[i].held_cost = sums[n].cost() - cross * cross / information;
  }
}

constexpr std::array<std::string_view, kOutputCount> kChannels = {"um", "ia", "n"};

SensorFit FitTrial(const FitContext& context, const Trial& trial) {
  const Eigen::Index n = context.coordinates();
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(1 + n);
  prior.mean.tail(n) = context.calibration.mean;
  prior.information = Eigen::MatrixXd::Zero(1 + n, 1 + n);
  prior.information(0, 0) = 1.0 / (kPriorSd * kPriorSd);
  prior.information.bottomRightCorner(n, n) = context.calibration.information;
  const StretchModels models{context.stretch, [&](const Eigen::VectorXd& q, std::size_t) {
                               const RigParameters rig = context.RigAt(q.tail(n));
                               return context.ModelOf(Changed(rig, trial, q(0)));
                             }};
  Eigen::VectorXd start = prior.mean;
  start(0) = std::clamp(trial.start, -1.0, 1.0);
  const MapFit fit = FitMap(models, prior, start, context.FitOptions());
  SensorFit found;
  found.cost = fit.cost();
  found.chi2 = fit.innovations.chi2;
  found.count = fit.innovations.count;
  SensorChange& change = found.change;
  change.channel = kChannels[trial.channel];
  change.gain = trial.gain;
  const double sd = std::sqrt(std::max(0.0, fit.covariance(0, 0)));
  // A speed is given as it is read, in rpm behind the gear.
  const double per_unit =
      trial.channel == 2 ? RadPerSecondOfRpm(context.rig.plant.gear_ratio) : 1.0;
  change.value = trial.gain ? std::exp(fit.point(0)) : fit.point(0) * trial.unit / per_unit;
  change.sigma = trial.gain ? change.value * sd : sd * trial.unit / per_unit;
  return found;
}

}  // namespace

std::optional<SensorFit> BestSensor(const FitContext& context, double worth_cost) {
  std::vector<Trial> trials = TrialsOf(context);
  if (trials.empty()) return std::nullopt;
  TryHeld(context, trials);
  std::sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
    return a.held_cost < b.held_cost;
  });
  std::optional<SensorFit> best;
  for (std::size_t i = 0; i < std::min(kFitted, trials.size()); ++i) {
    if (!(trials[i].held_cost < worth_cost)) break;
    SensorFit fit = FitTrial(context, trials[i]);
    if (!best || fit.cost < best->cost) best = std::move(fit);
  }
  return best;
}

}  // namespace faultlab::core
