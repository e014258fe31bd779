#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {

/// What is known of coordinates before the stretch: N(mean, information^-1). A zero row and column
/// of `information` is a flat prior.
struct GaussianPrior {
  Eigen::VectorXd mean;
  Eigen::MatrixXd information;
};

/// What is fitted: the models that a point in coordinates means along a stretch.
struct StretchModels {
  std::span<const Observation> stretch;
  std::function<PredictionModel(const Eigen::VectorXd& point, std::size_t segment)> model_at;
  std::vector<std::size_t> from = {0};  ///< first sample of each segment
};

struct MapFit {
  Eigen::VectorXd point;
  Eigen::MatrixXd covariance;   ///< posterior, Gauss-Newton
  Eigen::MatrixXd information;  ///< of the data alone
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
  /// A fit that cannot come below this cost is given up where it stands, not converged.
  double give_up_above = std::numeric_limits<double>::infinity();
};

/// argmin over q of  chi2(q) + log det S(q) + (q - mean)' information (q - mean)
/// by damped Gauss-Newton on the whitened innovations, sensitivities by forward differences.
/// Cost of an iteration: the models of the point and of its neighbours, run side by side.
/// Contract: at most 11 coordinates.
MapFit FitMap(const StretchModels& models,
              const GaussianPrior& prior,
              const Eigen::VectorXd& start,
              const MapFitOptions& options = {});

}  // namespace faultlab::core
