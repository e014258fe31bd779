#include "core/isolation/nominal_context.h"

#include <cmath>
#include <vector>

#include "core/numerics/linear_systems.h"

namespace faultlab::core {
namespace {

// Empty unless it is of all coordinates.
Eigen::MatrixXd SquareOf(const std::vector<double>& numbers, const Calibration& calibration) {
  if (numbers.size() != calibration.covariance.size()) return {};
  const auto n = std::lround(std::sqrt(static_cast<double>(numbers.size())));
  return Eigen::Map<const Eigen::MatrixXd>(numbers.data(), n, n);
}

}  // namespace

GaussianPrior PriorOf(const Calibration& calibration) {
  Eigen::MatrixXd covariance = CovarianceOf(calibration);
  covariance.diagonal().array() += 1e-12;
  return {Eigen::VectorXd::Zero(covariance.rows()), InverseOfSymmetric(covariance)};
}

FitContext NominalContext(const IsolationTask& task) {
  const Calibration& calibration = *task.calibration;
  FitContext nominal;
  nominal.rig = ParametersOf(calibration);
  nominal.noise = NoiseOf(calibration);
  nominal.calibration = PriorOf(calibration);
  nominal.tolerance_covariance = SquareOf(calibration.tolerance_covariance, calibration);
  nominal.model_covariance = SquareOf(calibration.model_covariance, calibration);
  nominal.part_tolerance = calibration.part_tolerance;
  nominal.period_s = task.options.period_s;
  nominal.follow_noise = task.options.bench->fits_follow_noise;
  return nominal;
}

}  // namespace faultlab::core
