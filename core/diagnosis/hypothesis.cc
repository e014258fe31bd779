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
// The scan needs no more to see where the valley is, the section search no more to get near.
constexpr std::size_t kScanSamples = 120;
constexpr std::size_t kRefineSamples = 300;
constexpr int kRefinements = 12;
// Rise of the cost that a bound must reach: three standard deviations.
constexpr double kBoundCost = 9.0;
// A rise with the other parameters held; up to here they could still take the end's side.
constexpr double kClosedCost = 60.0;
// A drifting value is held for this many samples; the filter does not resolve finer steps.
constexpr std::size_t kDriftBlock = 10;
// From a constant to a slope is a short way; what needs more steps is no slope.
constexpr int kDriftIterations = 6;
// From one optimum to its neighbour.
constexpr int kCapacitorIterations = 3;
// When a stretch before an alarm counts as healthy: its energy, and how far it moves what is known
// (chi-square with 8 degrees of freedom, 99.99 % at 31).
constexpr double kHealthySigmas = 4.0;
constexpr double kHealthyMargin = 0.15;
constexpr double kHealthyPriorCost = 31.0;
// Prior of a released coordinate: a factor of e either way.
constexpr double kFreeSd = 1.0;

double McVariance(const FitContext& context) {
  Eigen::MatrixXd information = context.calibration.information;
  information.diagonal().array() += 1e-9;
  const Eigen::MatrixXd covariance =
      information.ldlt().solve(Eigen::MatrixXd::Identity(kCoordinateCount, kCoordinateCount));
  const auto mc = static_cast<Eigen::Index>(Coordinate::kMc);
  return covariance(mc, mc) * kMcUnitNm * kMcUnitNm;
}

// Cost along one component, with Mc, which enters linearly, at its best under its marginal prior.
class QuickCost {
 public:
  QuickCost(const FitContext& context, Component component)
      : context_(context), component_(component), mc_variance_(McVariance(context)) {}

  double At(double log_value,
            std::span<const Observation> stretch,
            InnovationSummary* out = nullptr) const {
    const RigParameters rig = WithComponent(context_.rig, component_, std::exp(log_value));
    const InnovationSummary sum =
        RunInnovations(MakePredictionModel(rig, context_.noise, context_.period_s), stretch);
    const double gain = sum.mc_cross * sum.mc_cross / (sum.mc_square + 1.0 / mc_variance_);
    if (out != nullptr) *out = sum;
    const double cost = sum.cost() - gain;
    return std::isfinite(cost) ? cost : std::numeric_limits<double>::max();
  }

 private:
  const FitContext& context_;
  Component component_;
  double mc_variance_;
};

RigParameters MovedBy(const FitContext& context,
                      const RigParameters& rig,
                      const Eigen::VectorXd& q) {
  Coordinates nuisance;
  for (int i = 0; i < kCoordinateCount; ++i) nuisance[static_cast<std::size_t>(i)] = q(i);
  return Moved(rig, nuisance, context.period_s);
}

InnovationSummary Run(const FitContext& context, const RigParameters& rig, InnovationTrace* trace) {
  return RunInnovations(
      MakePredictionModel(rig, context.noise, context.period_s), context.stretch, trace);
}

// Is the cost flat towards one end of the range? Then the value is no more than a bound.
void FindBound(const FitContext& context, const Range& range, HypothesisFit& h) {
  FitContext moved = context;
  moved.rig = MovedBy(context, context.rig, h.nuisance);
  const QuickCost quick(moved, h.component);
  const double low = std::log(range.low);
  const double high = std::log(range.high);
  const double floor = quick.At(std::log(h.value), context.stretch);
  const auto is_open = [&](double end) {
    const double rise = quick.At(end, context.stretch) - floor;
    if (rise < kBoundCost || rise > kClosedCost) return rise < kBoundCost;
    return FitComponentAt(context, h.component, std::exp(end)).cost - h.cost < kBoundCost;
  };
  const bool open_low = is_open(low);
  const bool open_high = is_open(high);
  if (open_low == open_high) return;
  double inside = std::log(h.value);
  double outside = open_low ? high : low;
  for (int i = 0; i < kRefinements; ++i) {
    const double middle = 0.5 * (inside + outside);
    (quick.At(middle, context.stretch) - floor < kBoundCost ? inside : outside) = middle;
  }
  h.value = std::exp(inside);
  h.bound = open_low ? '<' : '>';
}

// (log of the change / log 10)^2: a part is rather ten times off than a hundred times. C8 has no
// size below 1 uF that matters.
double SizeCost(const PlantParameters& plant, const HypothesisFit& h) {
  constexpr double kLeastVisibleC8 = 1e-6;
  const double from = h.component == Component::kC8 ? kLeastVisibleC8 : plant.Get(h.component);
  const double decades = std::log10(h.value / from);
  return decades * decades;
}

// The calibration's prior behind `extra` logarithms of values. They are as good as free around
// where the scan found them; the little that is known keeps a flat cost from being a singular one.
constexpr double kValueLogSd = 4.0;
GaussianPrior WithValues(const GaussianPrior& calibration, int extra, double log_value) {
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(extra + kCoordinateCount);
  prior.mean.tail(kCoordinateCount) = calibration.mean;
  prior.information = Eigen::MatrixXd::Zero(extra + kCoordinateCount, extra + kCoordinateCount);
  prior.information.bottomRightCorner(kCoordinateCount, kCoordinateCount) = calibration.information;
  for (int i = 0; i < extra; ++i) {
    prior.mean(i) = log_value;
    prior.information(i, i) = 1.0 / (kValueLogSd * kValueLogSd);
  }
  return prior;
}

// The eight nuisances under the calibration, with component (if any) fixed.
HypothesisFit FitNuisance(const FitContext& context, const Component* component, double value) {
  const auto run = [&](const Eigen::VectorXd& q, InnovationTrace* trace) {
    const RigParameters rig = MovedBy(context, context.rig, q);
    return Run(context, component != nullptr ? WithComponent(rig, *component, value) : rig, trace);
  };
  const MapFit fit = FitMap(run, context.calibration, context.calibration.mean);
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

// Variance of log(value) that comes from not knowing which resistor an offset of the gain belongs
// to: k is known, but a fault replaces one part and leaves the offsets of the others.
double PartVariance(const FitContext& context, const HypothesisFit& h) {
  const PlantParameters& p = context.rig.plant;
  const double r9 = p.r10_ohm / (p.r9_ohm + p.r10_ohm);  // -d log k / d log R9, R10 has the rest
  const double r12 = p.r12_ohm / p.re2_ohm();
  const double r14 = p.r14_ohm / p.re2_ohm();
  const double r15 = p.r15_ohm / p.re2_ohm();
  const double all = r9 * r9 + (1.0 - r9) * (1.0 - r9) + r12 * r12 + r14 * r14 + r15 * r15;
  double own = 0.0;
  double slope = 0.0;  // d log(value) / d log(k)
  if (h.component == Component::kR9) {
    own = r9 * r9;
    slope = (h.value + p.r10_ohm) / p.r10_ohm;
  } else if (h.component == Component::kR12) {
    own = r12 * r12;
    slope = (h.value + p.r14_ohm + p.r15_ohm) / h.value;
  } else {
    return 0.0;
  }
  const double share = own / all;
  const double expected = share * std::log(context.rig.gain_factor);
  const double spread = context.part_tolerance * context.part_tolerance * share * (all - own);
  return slope * slope * (expected * expected + spread);
}

// The same for C8, whose time constant is C8 (Re2 + R5): how far its fit moves with Re2 a tolerance
// off, the measured gain kept.
double CapacitorVariance(const FitContext& context,
                         const GaussianPrior& prior,
                         const Eigen::VectorXd& point) {
  const PlantParameters& nominal = context.rig.plant;
  const double re2_ohm = nominal.re2_ohm();
  const double factor = std::exp(context.part_tolerance);
  RigParameters off = context.rig;
  off.plant.r12_ohm *= factor;
  off.plant.r14_ohm *= factor;
  off.plant.r15_ohm *= factor;
  off.gain_factor *= nominal.gain() / off.plant.gain();
  const auto run = [&](const Eigen::VectorXd& q, InnovationTrace* trace) {
    const RigParameters rig = MovedBy(context, off, q.tail(kCoordinateCount));
    return Run(context, WithComponent(rig, Component::kC8, std::exp(q(0))), trace);
  };
  MapFitOptions options;
  options.iterations_max = kCapacitorIterations;
  const double shift = FitMap(run, prior, point, options).point(0) - point(0);
  // The resistors of Re2 are off independently of each other.
  const double r12 = nominal.r12_ohm / re2_ohm;
  const double r14 = nominal.r14_ohm / re2_ohm;
  const double r15 = nominal.r15_ohm / re2_ohm;
  return shift * shift * (r12 * r12 + r14 * r14 + r15 * r15);
}

// Standard error of unknown `row` of a fit whose last coordinates are the calibration's: what the
// fit says, what doubt about the calibration adds, what the parts' tolerances add.
double LogSigma(const FitContext& context,
                const MapFit& fit,
                Eigen::Index row,
                const HypothesisFit& h) {
  double variance = std::max(0.0, fit.covariance(row, row)) + PartVariance(context, h);
  if (context.doubt.size() > 0) {
    // d log(value) / d(mean of the prior)
    const Eigen::VectorXd leaning =
        context.calibration.information * fit.covariance.col(row).tail(kCoordinateCount);
    variance += std::max(0.0, leaning.dot(context.doubt * leaning));
  }
  return std::sqrt(variance);
}

}  // namespace

RigParameters WithComponent(const RigParameters& rig, Component component, double value) {
  RigParameters changed = rig;
  changed.plant.Set(component, value);
  return changed;
}

void LearnMore(std::span<const Observation> stretch, FitContext& context) {
  const auto run = [&](const Eigen::VectorXd& q, InnovationTrace* trace) {
    const RigParameters rig = MovedBy(context, context.rig, q);
    return RunInnovations(
        MakePredictionModel(rig, context.noise, context.period_s), stretch, trace);
  };
  const GaussianPrior before = context.calibration;
  const MapFit fit = FitMap(run, before, before.mean);
  const double n = std::max(1, fit.innovations.count);
  const bool healthy =
      fit.converged &&
      fit.innovations.chi2 / n < 1.0 + kHealthySigmas * std::sqrt(2.0 / n) + kHealthyMargin &&
      fit.prior_cost < kHealthyPriorCost;
  if (!healthy) return;
  context.calibration = {fit.point, before.information + fit.information};
  if (context.doubt.size() == 0) return;
  // An error of the old mean is carried into the new one by this.
  const Eigen::MatrixXd kept = context.calibration.information.ldlt().solve(before.information);
  const Eigen::MatrixXd doubt = kept * context.doubt * kept.transpose();
  context.doubt = doubt;
}

HypothesisFit FitNothing(const FitContext& context) {
  return FitNuisance(context, nullptr, 0.0);
}

HypothesisFit FitComponentAt(const FitContext& context, Component component, double value) {
  return FitNuisance(context, &component, value);
}

HypothesisFit ScanComponent(const FitContext& context, Component component) {
  const Range& range = kRanges[static_cast<std::size_t>(component)];
  const auto scan = context.stretch.first(std::min(kScanSamples, context.stretch.size()));
  const auto refine = context.stretch.first(std::min(kRefineSamples, context.stretch.size()));
  const double low = std::log(range.low);
  const double step = (std::log(range.high) - low) / (range.points - 1);
  QuickCost quick(context, component);
  int best = 0;
  double best_cost = std::numeric_limits<double>::max();
  for (int i = 0; i < range.points; ++i) {
    const double cost = quick.At(low + i * step, scan);
    if (cost < best_cost) {
      best_cost = cost;
      best = i;
    }
  }
  // Golden section between the neighbours.
  constexpr double kGolden = 0.6180339887498949;
  double a = low + std::max(0, best - 1) * step;
  double b = low + std::min(range.points - 1, best + 1) * step;
  double x1 = b - kGolden * (b - a);
  double x2 = a + kGolden * (b - a);
  double f1 = quick.At(x1, refine);
  double f2 = quick.At(x2, refine);
  for (int i = 0; i < kRefinements; ++i) {
    if (f1 < f2) {
      b = x2;
      x2 = x1;
      f2 = f1;
      x1 = b - kGolden * (b - a);
      f1 = quick.At(x1, refine);
    } else {
      a = x1;
      x1 = x2;
      f1 = f2;
      x2 = a + kGolden * (b - a);
      f2 = quick.At(x2, refine);
    }
  }
  const double x = f1 < f2 ? x1 : x2;
  HypothesisFit h;
  h.component = component;
  h.exists = true;
  h.value = std::exp(x);
  h.log_sigma = std::numeric_limits<double>::quiet_NaN();
  h.nuisance = context.calibration.mean;
  h.size_cost = SizeCost(context.rig.plant, h);
  InnovationSummary sum;
  h.cost = quick.At(x, context.stretch, &sum);
  h.chi2 = sum.chi2;
  h.count = sum.count;
  return h;
}

void RefineComponent(const FitContext& context, HypothesisFit& h) {
  const Range& range = kRanges[static_cast<std::size_t>(h.component)];
  const GaussianPrior prior = WithValues(context.calibration, 1, std::log(h.value));
  const Eigen::VectorXd start = prior.mean;
  const auto run = [&](const Eigen::VectorXd& q, InnovationTrace* trace) {
    const RigParameters rig = MovedBy(context, context.rig, q.tail(kCoordinateCount));
    return Run(context, WithComponent(rig, h.component, std::exp(q(0))), trace);
  };
  const MapFit fit = FitMap(run, prior, start);
  h.value = std::clamp(std::exp(fit.point(0)), range.low, range.high);
  h.log_sigma = LogSigma(context, fit, 0, h);
  if (h.component == Component::kC8 && context.part_tolerance > 0.0) {
    h.log_sigma = std::hypot(h.log_sigma, std::sqrt(CapacitorVariance(context, prior, fit.point)));
  }
  h.chi2 = fit.innovations.chi2;
  h.count = fit.innovations.count;
  h.cost = fit.cost();
  h.nuisance = fit.point.tail(kCoordinateCount);
  FindBound(context, range, h);
  h.size_cost = SizeCost(context.rig.plant, h);
}

DriftFit FitDrift(const FitContext& context, const HypothesisFit& from) {
  const std::size_t n = context.stretch.size();
  const std::size_t blocks = (n + kDriftBlock - 1) / kDriftBlock;
  std::vector<PredictionModel> models(blocks);
  std::vector<ModelSegment> segments(blocks);
  for (std::size_t b = 0; b < blocks; ++b) segments[b] = {b * kDriftBlock, &models[b]};
  const auto run = [&](const Eigen::VectorXd& q, InnovationTrace* trace) {
    const RigParameters rig = MovedBy(context, context.rig, q.tail(kCoordinateCount));
    const double first = std::exp(q(0));
    const double last = std::exp(q(1));
    for (std::size_t b = 0; b < blocks; ++b) {
      const double share = (static_cast<double>(b) + 0.5) / static_cast<double>(blocks);
      models[b] =
          MakePredictionModel(WithComponent(rig, from.component, first + (last - first) * share),
                              context.noise,
                              context.period_s);
    }
    return RunInnovations(segments, context.stretch, trace);
  };
  const GaussianPrior prior = WithValues(context.calibration, 2, std::log(from.value));
  Eigen::VectorXd start = prior.mean;
  start.tail(kCoordinateCount) = from.nuisance;
  MapFitOptions options;
  options.iterations_max = kDriftIterations;
  const MapFit fit = FitMap(run, prior, start, options);
  DriftFit drift;
  drift.first_value = std::exp(fit.point(0));
  drift.fit = from;
  drift.fit.value = std::exp(fit.point(1));
  drift.fit.log_sigma = LogSigma(context, fit, 1, drift.fit);
  drift.fit.bound = 0;
  drift.fit.chi2 = fit.innovations.chi2;
  drift.fit.count = fit.innovations.count;
  drift.fit.cost = fit.cost();
  drift.fit.nuisance = fit.point.tail(kCoordinateCount);
  return drift;
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
  const auto run = [&](const Eigen::VectorXd& q, InnovationTrace* trace) {
    return Run(context, MovedBy(context, around, q), trace);
  };
  const MapFit fit = FitMap(run, prior, from.nuisance);
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
