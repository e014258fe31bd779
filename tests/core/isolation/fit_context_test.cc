#include "core/isolation/fit_context.h"

#include <gtest/gtest.h>

#include "tests/core/isolation/fault_stretch.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

TEST(UpdatePosterior, LearnsFromAHealthyStretch) {
  FaultStretch healthy({}, 151, 0.02);
  const Eigen::MatrixXd before = healthy.context.calibration.information;
  UpdatePosterior(healthy.context.stretch, healthy.context);
  const Eigen::MatrixXd& after = healthy.context.calibration.information;
  for (int i = 0; i < kCoordinateCount; ++i) EXPECT_GE(after(i, i), before(i, i)) << i;
  const auto gain = static_cast<Eigen::Index>(Coordinate::kGain);
  EXPECT_GT(after(gain, gain), 10.0 * before(gain, gain));
  EXPECT_NEAR(healthy.context.calibration.mean(gain), 0.0, 0.005);
}

TEST(UpdatePosterior, LearnsNothingFromAStretchThatHoldsAFault) {
  FaultStretch faulty({AbruptFault(paper::kRa, 12.0, 1.0)}, 152, 0.02);
  const GaussianPrior before = faulty.context.calibration;
  UpdatePosterior(faulty.context.stretch, faulty.context);
  EXPECT_EQ(faulty.context.calibration.information, before.information);
  EXPECT_EQ(faulty.context.calibration.mean, before.mean);
}

TEST(UpdatePosterior, ShrinksTheToleranceCovarianceWithThePriorsWeight) {
  FaultStretch healthy({}, 153, 0.02);
  healthy.context.tolerance_covariance =
      1e-4 * Eigen::MatrixXd::Identity(kCoordinateCount, kCoordinateCount);
  UpdatePosterior(healthy.context.stretch, healthy.context);
  const auto gain = static_cast<Eigen::Index>(Coordinate::kGain);
  EXPECT_LT(healthy.context.tolerance_covariance(gain, gain), 1e-5);
  EXPECT_GE(healthy.context.tolerance_covariance(gain, gain), 0.0);
}

}  // namespace
}  // namespace faultlab::core
