#include "core/isolation/value_error.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

// Steps from one optimum to a nearby one.
constexpr int kCapacitorIterations = 3;

// The resistors of the amplifier that determine its gain.
struct GainParts {
  std::array<double, kAmplifierParametersMax> share{};  // d log k / d log(part), 0 for others
  double all = 0.0;                                     // sum of squares
};

GainParts GainPartsOf(const PlantParameters& p) {
  GainParts parts;
  const double gain = p.gain();
  for (int i = 0; i < p.structure->parameter_count() - kMotorParameters; ++i) {
    const double share =
        p.structure->slope(p.amplifier, i).gain * p.amplifier[static_cast<std::size_t>(i)] / gain;
    parts.share[static_cast<std::size_t>(i)] = share;
    parts.all += share * share;
  }
  return parts;
}

// Variance of log(value) because it is unknown which resistor causes an offset of the gain: k is
// known, but a fault replaces one resistor and leaves the offsets of the others.
double PartVariance(const FitContext& context, Component component, double value) {
  const int which = component.info().parameter - kMotorParameters;
  if (which < 0) return 0.0;
  const PlantParameters& p = context.rig.plant;
  const GainParts parts = GainPartsOf(p);
  const double own_share = parts.share[static_cast<std::size_t>(which)];
  if (own_share == 0.0 || parts.all == own_share * own_share) return 0.0;
  PlantParameters faulty = p;
  faulty.Set(component, value);
  // d log(value) / d log(k)
  const double slope = faulty.gain() / (p.structure->slope(faulty.amplifier, which).gain * value);
  const double own = own_share * own_share;
  const double share = own / parts.all;
  const double expected = share * std::log(context.rig.gain_factor);
  const double spread = context.part_tolerance * context.part_tolerance * share * (parts.all - own);
  return slope * slope * (expected * expected + spread);
}

}  // namespace

double CapacitorLogSigma(const FitContext& context,
                         Component capacitor,
                         const GaussianPrior& prior,
                         const Eigen::VectorXd& point) {
  const PlantParameters& nominal = context.rig.plant;
  const double factor = std::exp(context.part_tolerance);
  RigParameters off = context.rig;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < nominal.structure->parameter_count() - kMotorParameters; ++i) {
    const ResponseSlope slope = nominal.structure->slope(nominal.amplifier, i);
    if (slope.gain == 0.0 || slope.lag_s == 0.0) continue;
    double& part = off.plant.amplifier[static_cast<std::size_t>(i)];
    sum += part;
    squares += part * part;
    part *= factor;
  }
  if (sum == 0.0) return 0.0;
  // The measured gain stays the same.
  off.gain_factor *= nominal.gain() / off.plant.gain();
  const StretchModels models{
      context.stretch, [&](const Eigen::VectorXd& q, std::size_t) {
        const RigParameters rig = context.RigAt(off, q.tail(context.coordinates()));
        return context.ModelOf(WithComponent(rig, capacitor, std::exp(q(0))));
      }};
  MapFitOptions options = context.FitOptions();
  options.iterations_max = kCapacitorIterations;
  const double shift = FitMap(models, prior, point, options).point(0) - point(0);
  // The errors of the resistors are independent.
  return std::abs(shift) * std::sqrt(squares) / sum;
}

double LogSigma(const FitContext& context,
                const MapFit& fit,
                Eigen::Index row,
                Component component,
                double value) {
  double variance =
      std::max(0.0, fit.covariance(row, row)) + PartVariance(context, component, value);
  // d log(value) / d(mean of the prior)
  const Eigen::VectorXd slope =
      context.calibration.information * fit.covariance.col(row).tail(context.coordinates());
  if (context.tolerance_covariance.size() > 0) {
    variance += std::max(0.0, slope.dot(context.tolerance_covariance * slope));
  }
  if (context.model_covariance.size() > 0) {
    variance += std::max(0.0, slope.dot(context.model_covariance * slope));
    const int own = CoordinateOf(component.info(), context.rig.plant);
    if (own >= 0) variance += context.model_covariance(own, own);
  }
  return std::sqrt(variance);
}

}  // namespace faultlab::core
