#include "core/diagnosis/map_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

// Forward differences: the innovations are smooth in the coordinates, their rounding is 1e-12.
constexpr double kDifference = 1e-5;

double PriorCost(const GaussianPrior& prior, const Eigen::VectorXd& q) {
  const Eigen::VectorXd off = q - prior.mean;
  return off.dot(prior.information * off);
}

}  // namespace

MapFit FitMap(const InnovationsAt& run,
              const GaussianPrior& prior,
              const Eigen::VectorXd& start,
              const MapFitOptions& options) {
  const Eigen::Index n = start.size();
  LAB_CHECK(prior.mean.size() == n && prior.information.rows() == n, n);
  MapFit fit;
  fit.point = start;
  InnovationTrace base;
  InnovationTrace moved;
  fit.innovations = run(fit.point, &base);
  fit.prior_cost = PriorCost(prior, fit.point);
  double damping = 0.0;
  Eigen::MatrixXd jacobian;
  for (; fit.iterations < options.iterations_max; ++fit.iterations) {
    const auto rows = static_cast<Eigen::Index>(base.whitened.size());
    const Eigen::Map<const Eigen::VectorXd> z(base.whitened.data(), rows);
    jacobian.resize(rows, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      Eigen::VectorXd q = fit.point;
      q(i) += kDifference;
      run(q, &moved);
      jacobian.col(i) =
          (Eigen::Map<const Eigen::VectorXd>(moved.whitened.data(), rows) - z) / kDifference;
    }
    fit.information = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient =
        jacobian.transpose() * z + prior.information * (fit.point - prior.mean);
    const Eigen::MatrixXd curvature = fit.information + prior.information;
    bool accepted = false;
    double step_in_sigma = 0.0;
    for (int attempt = 0; attempt < 6 && !accepted; ++attempt) {
      Eigen::MatrixXd damped = curvature;
      damped.diagonal() += damping * curvature.diagonal();
      damped.diagonal().array() += 1e-9 * (1.0 + curvature.diagonal().maxCoeff() * 1e-9);
      Eigen::VectorXd step = damped.ldlt().solve(-gradient);
      const double longest = step.cwiseAbs().maxCoeff();
      if (!(longest < 1e6)) break;
      if (longest > options.step_max) step *= options.step_max / longest;
      step_in_sigma = std::sqrt(std::max(0.0, step.dot(curvature * step)));
      const Eigen::VectorXd q = fit.point + step;
      const InnovationSummary tried = run(q, &moved);
      const double tried_prior = PriorCost(prior, q);
      if (tried.cost() + tried_prior <= fit.cost() + 1e-6) {
        fit.point = q;
        fit.innovations = tried;
        fit.prior_cost = tried_prior;
        std::swap(base, moved);
        accepted = true;
        damping = damping > 1e-3 ? damping * 0.1 : 0.0;
      } else {
        damping = damping > 0.0 ? damping * 10.0 : 1e-2;
      }
    }
    if (!accepted || step_in_sigma < options.step_tolerance) {
      fit.converged = accepted || step_in_sigma < 1.0;
      break;
    }
  }
  Eigen::MatrixXd curvature = fit.information + prior.information;
  curvature.diagonal().array() += 1e-9;
  fit.covariance = curvature.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  return fit;
}

}  // namespace faultlab::core
