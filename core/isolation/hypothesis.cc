#include "core/isolation/hypothesis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/filter/speed_response.h"
#include "core/isolation/profile_cost.h"
#include "core/isolation/value_error.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// A value is a bound if its cost rises by less than this: three standard deviations.
constexpr double kBoundCost = 9.0;
// Rise of the cost while the other parameters are held. Below this, fitting them too could bring
// the rise under kBoundCost.
constexpr double kClosedCost = 60.0;
// Number of bisections between the value and the end of its range.
constexpr int kBoundHalvings = 12;
// A slope lies near the constant value that was fitted; a fit that needs more steps is not a slope.
constexpr int kDriftIterations = 6;
// Standard deviation of the relaxed prior of a coordinate: a factor of e either way.
constexpr double kFreeSd = 1.0;

// Tests whether the cost is flat towards one end of the range; if so, the value is only a bound.
void FindBound(const FitContext& context, HypothesisFit& h) {
  FitContext moved = context;
  moved.rig = context.RigAt(h.nuisance);
  ProfileCost quick(moved);
  const ValueRange range = RangeOf(h.component);
  const double low = std::log(range.low);
  const double high = std::log(range.high);
  const double value = std::log(h.value);
  const std::array<ProfileCost::Point, 3> points = {
      {{h.component, value}, {h.component, low}, {h.component, high}}};
  const std::vector<ProfileCost::Result>& results = quick.At(points, context.stretch);
  const double floor = results[0].cost;
  const std::array<double, 2> rises = {results[1].cost - floor, results[2].cost - floor};
  const auto is_open = [&](double end, double rise) {
    if (rise < kBoundCost || rise > kClosedCost) return rise < kBoundCost;
    return FitComponentAt(context, h.component, std::exp(end)).cost - h.cost < kBoundCost;
  };
  const bool open_low = is_open(low, rises[0]);
  const bool open_high = is_open(high, rises[1]);
  if (open_low == open_high) return;
  double inside = value;
  double outside = open_low ? high : low;
  for (int i = 0; i < kBoundHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    const double rise = quick.At({h.component, middle}, context.stretch) - floor;
    (rise < kBoundCost ? inside : outside) = middle;
  }
  h.value = std::exp(inside);
  h.bound = open_low ? '<' : '>';
}

// The calibration's prior with `extra` logarithms of values in front.
GaussianPrior WithValues(const GaussianPrior& calibration, int extra, double log_value) {
  GaussianPrior prior;
  const Eigen::Index n = calibration.mean.size();
  prior.mean = Eigen::VectorXd::Zero(extra + n);
  prior.mean.tail(n) = calibration.mean;
  prior.information = Eigen::MatrixXd::Zero(extra + n, extra + n);
  prior.information.bottomRightCorner(n, n) = calibration.information;
  for (int i = 0; i < extra; ++i) {
    prior.mean(i) = log_value;
    prior.information(i, i) = 1.0 / (kValueLogSd * kValueLogSd);
  }
  return prior;
}

// Copies what every fit of value(s) and coordinates finds; value, error and bound are the caller's.
void Adopt(const FitContext& context, const MapFit& fit, HypothesisFit& h) {
  h.chi2 = fit.innovations.chi2;
  h.count = fit.innovations.count;
  h.cost = fit.cost();
  h.nuisance = fit.point.tail(context.coordinates());
}

// The eight nuisances under the calibration, with component (if any) fixed.
HypothesisFit FitNuisance(const FitContext& context, const Component* component, double value) {
  const StretchModels models{
      context.stretch, [&](const Eigen::VectorXd& q, std::size_t) {
        const RigParameters rig = context.RigAt(q);
        return context.ModelOf(component != nullptr ? WithComponent(rig, *component, value) : rig);
      }};
  HypothesisFit h;
  if (component != nullptr) h.component = *component;
  h.exists = true;
  h.value = value;
  Adopt(context,
        FitMap(models, context.calibration, context.calibration.mean, context.FitOptions()),
        h);
  return h;
}

/// @param fit  of the logarithm of the value and of the coordinates
SpeedResponse ResponseWith(const FitContext& context, const MapFit& fit, Component component) {
  const Eigen::Index n = context.coordinates();
  Eigen::MatrixXd covariance = fit.covariance;
  if (context.model_covariance.rows() == n) {
    covariance.bottomRightCorner(n, n) += context.model_covariance;
  }
  const auto rig_at = [&](const Eigen::VectorXd& q) {
    return WithComponent(context.RigAt(q.tail(n)), component, std::exp(q(0)));
  };
  return SpeedResponseOf(rig_at, fit.point, covariance);
}

}  // namespace

double MagnitudePrior(const PlantParameters& plant, Component component, double value) {
  // Capacitances below 1 uF have no visible effect.
  const double least = component.info().least_visible;
  const double from = least > 0.0 ? least : plant.Get(component);
  const double decades = std::log10(value / from);
  return decades * decades;
}

HypothesisFit FitNullHypothesis(const FitContext& context) {
  return FitNuisance(context, nullptr, 0.0);
}

HypothesisFit FitComponentAt(const FitContext& context, Component component, double value) {
  return FitNuisance(context, &component, value);
}

void RefineComponent(const FitContext& context, HypothesisFit& h, double give_up_above) {
  const ValueRange range = RangeOf(h.component);
  const GaussianPrior prior = WithValues(context.calibration, 1, std::log(h.value));
  const StretchModels models{
      context.stretch, [&](const Eigen::VectorXd& q, std::size_t) {
        const RigParameters rig = context.RigAt(q.tail(context.coordinates()));
        return context.ModelOf(WithComponent(rig, h.component, std::exp(q(0))));
      }};
  MapFitOptions options = context.FitOptions();
  options.give_up_above = give_up_above;
  const MapFit fit = FitMap(models, prior, prior.mean, options);
  h.value = std::clamp(std::exp(fit.point(0)), range.low, range.high);
  h.log_sigma = LogSigma(context, fit, 0, h.component, h.value);
  if (context.rig.plant.structure->estimated == EstimatedChannel::kSpeed) {
    h.response = ResponseWith(context, fit, h.component);
  }
  if (h.component.info().kind == PartKind::kCapacitor && context.part_tolerance > 0.0) {
    h.log_sigma =
        std::hypot(h.log_sigma, CapacitorLogSigma(context, h.component, prior, fit.point));
  }
  Adopt(context, fit, h);
  FindBound(context, h);
  h.magnitude_cost = MagnitudePrior(context.rig.plant, h.component, h.value);
}

DriftFit FitDrift(const FitContext& context, const HypothesisFit& from, std::size_t block) {
  const std::size_t n = context.stretch.size();
  const std::size_t block_samples = SpanOf(block, context.period_s);
  const std::size_t blocks = (n + block_samples - 1) / block_samples;
  StretchModels models{
      context.stretch, [&](const Eigen::VectorXd& q, std::size_t at) {
        const RigParameters rig = context.RigAt(q.tail(context.coordinates()));
        const double first = std::exp(q(0));
        const double last = std::exp(q(1));
        const double share = (static_cast<double>(at) + 0.5) / static_cast<double>(blocks);
        return context.ModelOf(WithComponent(rig, from.component, first + (last - first) * share));
      }};
  models.from.resize(blocks);
  for (std::size_t b = 0; b < blocks; ++b) models.from[b] = b * block_samples;
  const GaussianPrior prior = WithValues(context.calibration, 2, std::log(from.value));
  Eigen::VectorXd start = prior.mean;
  start.tail(context.coordinates()) = from.nuisance;
  MapFitOptions options = context.FitOptions();
  options.iterations_max = kDriftIterations;
  const MapFit fit = FitMap(models, prior, start, options);
  DriftFit drift;
  drift.first_value = std::exp(fit.point(0));
  drift.fit = from;
  drift.fit.value = std::exp(fit.point(1));
  drift.fit.log_sigma = LogSigma(context, fit, 1, from.component, drift.fit.value);
  drift.fit.bound = 0;
  Adopt(context, fit, drift.fit);
  return drift;
}

RelaxedFit FitRelaxed(const FitContext& context, const HypothesisFit& from) {
  GaussianPrior prior;
  const Eigen::Index n = context.coordinates();
  prior.mean = Eigen::VectorXd::Zero(n);
  prior.information = Eigen::MatrixXd::Identity(n, n) / (kFreeSd * kFreeSd);
  // delta belongs to the converters, and La to no component: nothing moves them.
  for (Eigen::Index i = static_cast<Eigen::Index>(Coordinate::kDelta); i < n; ++i) {
    prior.information(i, i) = context.calibration.information(i, i);
  }
  const auto mc = static_cast<Eigen::Index>(Coordinate::kMc);
  prior.information(mc, mc) = 1.0 / (10.0 * 10.0);
  const RigParameters around = WithComponent(context.rig, from.component, from.value);
  const StretchModels models{context.stretch, [&](const Eigen::VectorXd& q, std::size_t) {
                               return context.ModelOf(context.RigAt(around, q));
                             }};
  const MapFit fit = FitMap(models, prior, from.nuisance, context.FitOptions());
  RelaxedFit free;
  free.cost = fit.innovations.cost();
  free.point = fit.point.head(context.calibrated());
  free.sigma = fit.covariance.diagonal().head(context.calibrated()).cwiseMax(0.0).cwiseSqrt();
  return free;
}

double PredictionDistance(const FitContext& context,
                          const HypothesisFit& a,
                          const HypothesisFit& b) {
  const auto model_of = [&](const HypothesisFit& h) {
    return context.ModelOf(WithComponent(context.RigAt(h.nuisance), h.component, h.value));
  };
  const std::array<PredictionModel, 2> models = {model_of(a), model_of(b)};
  const std::array<ModelSegment, 2> segments = {{{0, &models[0]}, {0, &models[1]}}};
  const std::array<ModelPath, 2> paths = {ModelPath(&segments[0], 1), ModelPath(&segments[1], 1)};
  std::array<InnovationSummary, 2> sums;
  InnovationTable table;
  RunInnovations(paths, context.stretch, sums, &table);
  return (table.col(0) - table.col(1)).squaredNorm() /
         static_cast<double>(std::max<std::size_t>(1, context.stretch.size()));
}

}  // namespace faultlab::core
