#include "core/isolation/value_error.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

// From one optimum to its neighbour.
constexpr int kCapacitorIterations = 3;

// Variance of log(value) that comes from not knowing which resistor an offset of the gain belongs
// to: k is known, but a fault replaces one part and leaves the offsets of the others.
double PartVariance(const FitContext& context, Component component, double value) {
  const PlantParameters& p = context.rig.plant;
  const double r9 = p.r10_ohm / (p.r9_ohm + p.r10_ohm);  // -d log k / d log R9, R10 has the rest
  const double r12 = p.r12_ohm / p.re2_ohm();
  const double r14 = p.r14_ohm / p.re2_ohm();
  const double r15 = p.r15_ohm / p.re2_ohm();
  const double all = r9 * r9 + (1.0 - r9) * (1.0 - r9) + r12 * r12 + r14 * r14 + r15 * r15;
  double own = 0.0;
  double slope = 0.0;  // d log(value) / d log(k)
  if (component == Component::kR9) {
    own = r9 * r9;
    slope = (value + p.r10_ohm) / p.r10_ohm;
  } else if (component == Component::kR12) {
    own = r12 * r12;
    slope = (value + p.r14_ohm + p.r15_ohm) / value;
  } else {
    return 0.0;
  }
  const double share = own / all;
  const double expected = share * std::log(context.rig.gain_factor);
  const double spread = context.part_tolerance * context.part_tolerance * share * (all - own);
  return slope * slope * (expected * expected + spread);
}

}  // namespace

double CapacitorLogSigma(const FitContext& context,
                         const GaussianPrior& prior,
                         const Eigen::VectorXd& point) {
  const PlantParameters& nominal = context.rig.plant;
  const double re2_ohm = nominal.re2_ohm();
  const double factor = std::exp(context.part_tolerance);
  RigParameters off = context.rig;
  off.plant.r12_ohm *= factor;
  off.plant.r14_ohm *= factor;
  off.plant.r15_ohm *= factor;
  // The gain has been measured.
  off.gain_factor *= nominal.gain() / off.plant.gain();
  const StretchModels models{
      context.stretch, [&](const Eigen::VectorXd& q, std::size_t) {
        const RigParameters rig = WithOffsets(off, q.tail(kCoordinateCount), context.period_s);
        return context.ModelOf(WithComponent(rig, Component::kC8, std::exp(q(0))));
      }};
  MapFitOptions options;
  options.iterations_max = kCapacitorIterations;
  const double shift = FitMap(models, prior, point, options).point(0) - point(0);
  // The resistors of Re2 are off independently of each other.
  const double r12 = nominal.r12_ohm / re2_ohm;
  const double r14 = nominal.r14_ohm / re2_ohm;
  const double r15 = nominal.r15_ohm / re2_ohm;
  return std::abs(shift) * std::sqrt(r12 * r12 + r14 * r14 + r15 * r15);
}

double LogSigma(const FitContext& context,
                const MapFit& fit,
                Eigen::Index row,
                Component component,
                double value) {
  double variance =
      std::max(0.0, fit.covariance(row, row)) + PartVariance(context, component, value);
  if (context.tolerance_covariance.size() > 0) {
    // d log(value) / d(mean of the prior)
    const Eigen::VectorXd slope =
        context.calibration.information * fit.covariance.col(row).tail(kCoordinateCount);
    variance += std::max(0.0, slope.dot(context.tolerance_covariance * slope));
  }
  return std::sqrt(variance);
}

}  // namespace faultlab::core
