#include "core/isolation/value_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/isolation/fault_stretch.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

// A fit of one value with the eight coordinates: the value has variance 1e-4 and depends on the
// first coordinate's mean with slope 2.
MapFit MadeFit(const FitContext& context) {
  MapFit fit;
  fit.covariance = Eigen::MatrixXd::Zero(1 + kCoordinateCount, 1 + kCoordinateCount);
  fit.covariance(0, 0) = 1e-4;
  fit.covariance(0, 1) = fit.covariance(1, 0) = 2.0 / context.calibration.information(0, 0);
  return fit;
}

TEST(ValueError, IsTheFitsOwnWhenNothingElseIsUncertain) {
  FaultStretch fault({}, 141);
  EXPECT_NEAR(LogSigma(fault.context, MadeFit(fault.context), 0, paper::kRa, 9.0), 0.01, 1e-12);
}

TEST(ValueError, GrowsByTheToleranceCovarianceAlongTheSlope) {
  FaultStretch fault({}, 141);
  fault.context.tolerance_covariance =
      4e-4 * Eigen::MatrixXd::Identity(kCoordinateCount, kCoordinateCount);
  // 1e-4 + 2^2 4e-4
  EXPECT_NEAR(
      LogSigma(fault.context, MadeFit(fault.context), 0, paper::kRa, 9.0), std::sqrt(17e-4), 1e-9);
}

TEST(ValueError, GrowsByWhatTheModelLacksAlongTheSlopeAndAtItsOwnCoordinate) {
  FaultStretch fault({}, 141);
  fault.context.model_covariance = Eigen::MatrixXd::Zero(kCoordinateCount, kCoordinateCount);
  const auto ra = static_cast<Eigen::Index>(Coordinate::kRa);
  fault.context.model_covariance(0, 0) = 4e-4;
  fault.context.model_covariance(ra, ra) = 9e-4;
  const MapFit fit = MadeFit(fault.context);
  // 1e-4 + 2^2 4e-4, and 9e-4 of Ra alone
  EXPECT_NEAR(LogSigma(fault.context, fit, 0, paper::kRa, 9.0), std::sqrt(26e-4), 1e-9);
  EXPECT_NEAR(LogSigma(fault.context, fit, 0, paper::kJ, 2e-6), std::sqrt(17e-4), 1e-9);
}

TEST(ValueError, CountsTheOtherResistorsOfTheGainForR9AndR12Alone) {
  FaultStretch fault({}, 141);
  fault.context.part_tolerance = 0.01;
  const MapFit fit = MadeFit(fault.context);
  EXPECT_NEAR(LogSigma(fault.context, fit, 0, paper::kR1, 10.0), 0.01, 1e-12);
  EXPECT_GT(LogSigma(fault.context, fit, 0, paper::kR9, 33e3), 0.011);
  EXPECT_GT(LogSigma(fault.context, fit, 0, paper::kR12, 5.6e3), 0.011);
  // The more R9 exceeds R10, the less the gain depends on it.
  EXPECT_GT(LogSigma(fault.context, fit, 0, paper::kR9, 100e3),
            LogSigma(fault.context, fit, 0, paper::kR9, 33e3));
}

TEST(ValueError, OfACapacitorIsAboutTheToleranceOfTheResistorsBesideIt) {
  FaultStretch fault({AbruptFault(paper::kC8, 10e-6, 1.0)}, 142, 0.002);
  fault.context.part_tolerance = 0.02;
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(1 + kCoordinateCount);
  prior.mean(0) = std::log(10e-6);
  prior.information = Eigen::MatrixXd::Zero(1 + kCoordinateCount, 1 + kCoordinateCount);
  prior.information(0, 0) = 1.0 / 16.0;
  prior.information.bottomRightCorner(kCoordinateCount, kCoordinateCount) =
      fault.context.calibration.information;
  // tau = C8 (Re2 + R5): Re2 is 12 of 13 kohm, R12 alone 10 of them.
  const double sigma = CapacitorLogSigma(fault.context, paper::kC8, prior, prior.mean);
  EXPECT_GT(sigma, 0.005);
  EXPECT_LT(sigma, 0.03);
}

}  // namespace
}  // namespace faultlab::core
