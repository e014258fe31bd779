#include "core/diagnosis/hypothesis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace faultlab::core {
namespace {

struct Range {
  double low;
  double high;
  int points;
};

// From "short circuit" to "open" for each part; ends only bound the search.
constexpr std::array<Range, kComponentCount> kRanges = {{
    {0.02, 3e3, 22},
    {500.0, 5e6, 22},
    {20.0, 1e6, 24},
    {1e-8, 5e-3, 24},
    {0.05, 2e3, 22},
    {3e-9, 1e-3, 24},
    {1e-8, 1e-2, 22},
}};
constexpr std::size_t kScanSamples = 150;
constexpr int kRefinements = 14;
// Log standard error above which a value may be no more than a bound.
constexpr double kBoundLogSigma = 0.3;
// Rise of the cost that a bound must reach: two standard deviations.
constexpr double kBoundCost = 4.0;
// Prior of a released coordinate: a factor of e either way.
constexpr double kFreeSd = 1.0;

double McCoordinateVariance(const FitContext& context) {
  // Marginal variance of Mc: invert the information once per context is not worth a cache.
  Eigen::MatrixXd information = context.calibration.information;
  information.diagonal().array() += 1e-9;
  const Eigen::MatrixXd covariance =
      information.ldlt().solve(Eigen::MatrixXd::Identity(kCoordinateCount, kCoordinateCount));
  const auto mc = static_cast<Eigen::Index>(Coordinate::kMc);
  return covariance(mc, mc) * kMcUnitNm * kMcUnitNm;
}

// Cost with Mc, which enters linearly, at its best under its marginal prior.
double QuickCost(const FitContext& context,
                 const RigParameters& rig,
                 std::span<const Observation> stretch,
                 double mc_variance) {
  const InnovationSummary sum =
      RunInnovations(MakePredictionModel(rig, context.noise, context.period_s), stretch);
  const double gain = sum.mc_cross * sum.mc_cross / (sum.mc_square + 1.0 / mc_variance);
  const double cost = sum.cost() - gain;
  return std::isfinite(cost) ? cost : std::numeric_limits<double>::max();
}

RigAt ComponentAndNuisance(const FitContext& context, Component component) {
  return [&context, component](const Eigen::VectorXd& q) {
    Coordinates nuisance;
    for (int i = 0; i < kCoordinateCount; ++i) nuisance[static_cast<std::size_t>(i)] = q(i + 1);
    return WithComponent(Moved(context.rig, nuisance, context.period_s), component, std::exp(q(0)));
  };
}

RigAt NuisanceAt(const FitContext& context,
                 const RigParameters& rig,
                 Component* component,
                 double value) {
  const std::optional<Component> fixed =
      component != nullptr ? std::optional<Component>(*component) : std::nullopt;
  return [&context, rig, fixed, value](const Eigen::VectorXd& q) {
    Coordinates nuisance;
    for (int i = 0; i < kCoordinateCount; ++i) nuisance[static_cast<std::size_t>(i)] = q(i);
    const RigParameters moved = Moved(rig, nuisance, context.period_s);
    return fixed ? WithComponent(moved, *fixed, value) : moved;
  };
}

// The eight nuisances under the calibration, with component (if any) fixed.
HypothesisFit FitNuisance(const FitContext& context, Component* component, double value) {
  const MapFit fit = FitMap(NuisanceAt(context, context.rig, component, value),
                            context.noise,
                            context.period_s,
                            context.stretch,
                            context.calibration,
                            context.calibration.mean);
  HypothesisFit h;
  if (component != nullptr) h.component = *component;
  h.exists = true;
  h.value = value;
  h.chi2 = fit.innovations.chi2;
  h.count = fit.innovations.count;
  h.cost = fit.cost();
  h.nuisance = fit.point;
  return h;
}

}  // namespace

RigParameters WithComponent(const RigParameters& rig, Component component, double value) {
  RigParameters changed = rig;
  changed.plant.Set(component, value);
  return changed;
}

HypothesisFit FitNothing(const FitContext& context) {
  return FitNuisance(context, nullptr, 0.0);
}

HypothesisFit FitComponentAt(const FitContext& context, Component component, double value) {
  return FitNuisance(context, &component, value);
}

HypothesisFit FitComponent(const FitContext& context, Component component) {
  const Range& range = kRanges[static_cast<std::size_t>(component)];
  const double mc_variance = McCoordinateVariance(context);
  const auto scan = context.stretch.first(std::min(kScanSamples, context.stretch.size()));
  const double low = std::log(range.low);
  const double step = (std::log(range.high) - low) / (range.points - 1);
  std::vector<double> costs(static_cast<std::size_t>(range.points));
  const auto quick = [&](double x, std::span<const Observation> stretch) {
    return QuickCost(
        context, WithComponent(context.rig, component, std::exp(x)), stretch, mc_variance);
  };
  for (int i = 0; i < range.points; ++i) {
    costs[static_cast<std::size_t>(i)] = quick(low + i * step, scan);
  }
  const auto best = static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin());

  // Golden section between the neighbours, on the whole stretch.
  constexpr double kGolden = 0.6180339887498949;
  double a = low + std::max(0, best - 1) * step;
  double b = low + std::min(range.points - 1, best + 1) * step;
  double x1 = b - kGolden * (b - a);
  double x2 = a + kGolden * (b - a);
  double f1 = quick(x1, context.stretch);
  double f2 = quick(x2, context.stretch);
  for (int i = 0; i < kRefinements; ++i) {
    if (f1 < f2) {
      b = x2;
      x2 = x1;
      f2 = f1;
      x1 = b - kGolden * (b - a);
      f1 = quick(x1, context.stretch);
    } else {
      a = x1;
      x1 = x2;
      f1 = f2;
      x2 = a + kGolden * (b - a);
      f2 = quick(x2, context.stretch);
    }
  }

  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(kCoordinateCount + 1);
  prior.mean.tail(kCoordinateCount) = context.calibration.mean;
  prior.information = Eigen::MatrixXd::Zero(kCoordinateCount + 1, kCoordinateCount + 1);
  prior.information.bottomRightCorner(kCoordinateCount, kCoordinateCount) =
      context.calibration.information;
  Eigen::VectorXd start = prior.mean;
  start(0) = f1 < f2 ? x1 : x2;
  const MapFit fit = FitMap(ComponentAndNuisance(context, component),
                            context.noise,
                            context.period_s,
                            context.stretch,
                            prior,
                            start);
  HypothesisFit h;
  h.component = component;
  h.value = std::exp(std::clamp(fit.point(0), low, std::log(range.high)));
  h.exists = std::isfinite(fit.cost());
  h.log_sigma = std::sqrt(std::max(0.0, fit.covariance(0, 0)));
  h.chi2 = fit.innovations.chi2;
  h.count = fit.innovations.count;
  h.cost = fit.cost();
  h.nuisance = fit.point.tail(kCoordinateCount);

  if (h.log_sigma > kBoundLogSigma) {
    // The cost is flat: how far does it stay flat, and which way?
    const double floor = quick(std::log(h.value), context.stretch);
    const bool open_low = quick(low, context.stretch) - floor < kBoundCost;
    const bool open_high = quick(std::log(range.high), context.stretch) - floor < kBoundCost;
    if (open_low != open_high) {
      double inside = std::log(h.value);
      double outside = open_low ? std::log(range.high) : low;
      for (int i = 0; i < kRefinements; ++i) {
        const double middle = 0.5 * (inside + outside);
        (quick(middle, context.stretch) - floor < kBoundCost ? inside : outside) = middle;
      }
      h.value = std::exp(inside);
      h.bound = open_low ? '<' : '>';
    }
  }
  return h;
}

FreeFit FitFree(const FitContext& context, const HypothesisFit& from) {
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(kCoordinateCount);
  prior.information =
      Eigen::MatrixXd::Identity(kCoordinateCount, kCoordinateCount) / (kFreeSd * kFreeSd);
  // delta belongs to the converters: no component moves it.
  const auto delta = static_cast<Eigen::Index>(Coordinate::kDelta);
  prior.information.row(delta) = context.calibration.information.row(delta);
  prior.information.col(delta) = context.calibration.information.col(delta);
  prior.information.row(delta).setZero();
  prior.information.col(delta).setZero();
  prior.information(delta, delta) = context.calibration.information(delta, delta);
  const auto mc = static_cast<Eigen::Index>(Coordinate::kMc);
  prior.information(mc, mc) = 1.0 / (10.0 * 10.0);
  const RigParameters around = WithComponent(context.rig, from.component, from.value);
  const MapFit fit = FitMap(NuisanceAt(context, around, nullptr, 0.0),
                            context.noise,
                            context.period_s,
                            context.stretch,
                            prior,
                            Eigen::VectorXd::Zero(kCoordinateCount));
  FreeFit free;
  free.cost = fit.innovations.cost();
  free.point = fit.point;
  free.sigma = fit.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  return free;
}

double PredictionDistance(const FitContext& context,
                          const HypothesisFit& a,
                          const HypothesisFit& b) {
  const auto trace = [&](const HypothesisFit& h) {
    Coordinates nuisance;
    for (int i = 0; i < kCoordinateCount; ++i)
      nuisance[static_cast<std::size_t>(i)] = h.nuisance(i);
    InnovationTrace t;
    RunInnovations(
        MakePredictionModel(
            WithComponent(Moved(context.rig, nuisance, context.period_s), h.component, h.value),
            context.noise,
            context.period_s),
        context.stretch,
        &t);
    return t;
  };
  const InnovationTrace ta = trace(a);
  const InnovationTrace tb = trace(b);
  double sum = 0.0;
  for (std::size_t r = 0; r < ta.whitened.size(); ++r) {
    const double d = ta.whitened[r] - tb.whitened[r];
    sum += d * d;
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, context.stretch.size()));
}

}  // namespace faultlab::core
