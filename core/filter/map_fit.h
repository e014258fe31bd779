#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {

/// What is known of the coordinates before the stretch: N(mean, information^-1). A zero row and
/// column of `information` is a flat prior.
struct GaussianPrior {
  Eigen::VectorXd mean;         ///< [n]
  Eigen::MatrixXd information;  ///< [n x n], symmetric, positive semidefinite
};

/// What is fitted: gives the models along a stretch for a point in coordinates.
struct StretchModels {
  std::span<const Observation> stretch;
  std::function<PredictionModel(const Eigen::VectorXd& point, std::size_t segment)> model_at;
  std::vector<std::size_t> from = {0};  ///< first sample of each segment
};

struct MapFit {
  Eigen::VectorXd point;        ///< [n]
  Eigen::MatrixXd covariance;   ///< [n x n] posterior, (J'J + information of the prior)^-1
  Eigen::MatrixXd information;  ///< [n x n] of the data alone, J'J
  InnovationSummary innovations;
  double prior_cost = 0.0;  ///< (point - mean)' information (point - mean)
  int iterations = 0;
  bool converged = false;

  double cost() const { return innovations.cost() + prior_cost; }
};

struct MapFitOptions {
  int iterations_max = 12;
  /// Converged when a step is shorter than this in units of the posterior standard error.
  double step_tolerance = 0.02;
  /// Longest step of one coordinate; coordinates are logarithms or have unit scales of order one.
  double step_max = 0.7;
  /// A fit that cannot come below this cost is given up at the point reached, not converged.
  double give_up_above = std::numeric_limits<double>::infinity();
  /// Adds half of d log det S / dq to the slope. Without it a fit prefers parameters that make the
  /// prediction noisier, as far as the prior lets it: where no voltage is measured, all parameters
  /// may be scaled alike, and only tolerances and the noise of friction tell by how much.
  bool follow_noise = false;
};

/// argmin over q [n] of  chi2(q) + log det S(q) + (q - mean)' information (q - mean)
/// by Gauss-Newton on the whitened innovations z [readings],
///   (J'J + information) step = -(J'z + information (q - mean)),   J = dz/dq by forward differences
/// damped as Levenberg and Marquardt do when a step does not lower the cost; the change of log det
/// S with q is left out unless MapFitOptions asks for it. Cost of an iteration: the models of the
/// point and of its n neighbours, run side by side. No answer: `converged` is false when the
/// iterations ran out, when the fit was given up, and when no step of a standard error or more
/// lowered the cost; `point` is the best one tried. A direction that neither data nor prior
/// determine keeps its start, with a variance of 1e9. A start whose cost is not finite is returned
/// as it is: look at cost(). Contract: prior and start have the same n, 1 <= n <= 15
/// (ContractError). Source: K. Levenberg, Quart. Appl. Math. 2 (1944); D. W. Marquardt, J. SIAM 11
/// (1963); MAP: H. L. Van Trees, Detection, Estimation, and Modulation Theory I (1968),
/// section 2.4.
MapFit FitMap(const StretchModels& models,
              const GaussianPrior& prior,
              const Eigen::VectorXd& start,
              const MapFitOptions& options = {});

}  // namespace faultlab::core
