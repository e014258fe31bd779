#include "core/isolation/fit_context.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/numerics/linear_systems.h"

namespace faultlab::core {
namespace {

// A stretch before an alarm counts as healthy if its energy is small enough and if it moves the
// prior's mean by no more than this (chi-square with 8 degrees of freedom, 99.99 % at 31).
constexpr double kHealthySigmas = 4.0;
constexpr double kHealthyMargin = 0.15;
constexpr double kHealthyPriorCost = 31.0;

}  // namespace

RigParameters Moved(const RigParameters& base,
                    const Eigen::Ref<const Eigen::VectorXd>& q,
                    double period_s) {
  RigParameters moved = WithOffsets(base, q, period_s);
  const double more_b = q(static_cast<Eigen::Index>(Coordinate::kB));
  if (more_b > 0.0) moved.plant.b_nm_per_rad_s = base.plant.b_nm_per_rad_s * (1.0 + more_b);
  return moved;
}

RigParameters FitContext::RigAt(const RigParameters& base,
                                const Eigen::Ref<const Eigen::VectorXd>& q) const {
  RigParameters moved = Moved(base, q.head(calibrated()), period_s);
  if (direct_is_free) moved.direct_factor *= std::exp(q(calibrated()));
  return moved;
}

FitContext WithFreeDirect(const FitContext& context) {
  const Eigen::Index n = context.coordinates();
  const auto with_one_more = [&](const Eigen::MatrixXd& square) {
    if (square.size() == 0) return square;
    Eigen::MatrixXd larger = Eigen::MatrixXd::Zero(n + 1, n + 1);
    larger.topLeftCorner(n, n) = square;
    return larger;
  };
  // It is a ratio of two resistances.
  const double sd = std::numbers::sqrt2 * context.part_tolerance;
  FitContext free = context;
  free.direct_is_free = true;
  free.calibration.mean.conservativeResizeLike(Eigen::VectorXd::Zero(n + 1));
  free.calibration.information = with_one_more(context.calibration.information);
  free.calibration.information(n, n) = 1.0 / (sd * sd);
  free.tolerance_covariance = with_one_more(context.tolerance_covariance);
  free.model_covariance = with_one_more(context.model_covariance);
  return free;
}

RigParameters WithComponent(const RigParameters& rig, Component component, double value) {
  RigParameters changed = rig;
  changed.plant.Set(component, value);
  if (component.info().parameter == rig.gain_part) changed.gain_factor = 1.0;
  // What the lag is off the data sheet is mostly its capacitor's error.
  if (component.info().kind == PartKind::kCapacitor) changed.lag_factor = 1.0;
  return changed;
}

void UpdatePosterior(std::span<const Observation> stretch, FitContext& context) {
  const StretchModels models{stretch, [&](const Eigen::VectorXd& q, std::size_t) {
                               return context.ModelOf(context.RigAt(q));
                             }};
  const GaussianPrior before = context.calibration;
  const MapFit fit = FitMap(models, before, before.mean, context.FitOptions());
  const double n = std::max(1, fit.innovations.count);
  const bool healthy =
      fit.converged &&
      fit.innovations.chi2 / n < 1.0 + kHealthySigmas * std::sqrt(2.0 / n) + kHealthyMargin &&
      fit.prior_cost < kHealthyPriorCost;
  if (!healthy) return;
  context.calibration = {fit.point, before.information + fit.information};
  if (context.tolerance_covariance.size() == 0) return;
  // This matrix maps an error of the old mean to the error that it causes in the new mean.
  const Eigen::MatrixXd kept = SolveSymmetric(context.calibration.information, before.information);
  const Eigen::MatrixXd carried = kept * context.tolerance_covariance * kept.transpose();
  context.tolerance_covariance = carried;
}

}  // namespace faultlab::core
