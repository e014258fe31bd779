#include "core/isolation/nominal_context.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

template <int n>
GaussianPrior PriorOf(const double* numbers) {
  using Square = Eigen::Matrix<double, n, n>;
  const Eigen::Map<const Square> covariance(numbers);
  const Square regular = covariance + 1e-12 * Square::Identity();
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(n);
  prior.information = regular.ldlt().solve(Square::Identity());
  return prior;
}

// Empty unless it is of all coordinates.
Eigen::MatrixXd SquareOf(const std::vector<double>& numbers, const Calibration& calibration) {
  if (numbers.size() != calibration.covariance.size()) return {};
  const auto n = std::lround(std::sqrt(static_cast<double>(numbers.size())));
  return Eigen::Map<const Eigen::MatrixXd>(numbers.data(), n, n);
}

}  // namespace

GaussianPrior PriorOf(const Calibration& calibration) {
  const std::vector<double>& covariance = calibration.covariance;
  if (covariance.size() == kCoordinateMax * kCoordinateMax) {
    return PriorOf<kCoordinateMax>(covariance.data());
  }
  if (covariance.size() == kCoordinateCountWithLa * kCoordinateCountWithLa) {
    return PriorOf<kCoordinateCountWithLa>(covariance.data());
  }
  LAB_CHECK(covariance.size() == kCoordinateCount * kCoordinateCount, covariance.size());
  return PriorOf<kCoordinateCount>(covariance.data());
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
