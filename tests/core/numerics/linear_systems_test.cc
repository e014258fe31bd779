#include "core/numerics/linear_systems.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace faultlab::core {
namespace {

Eigen::MatrixXd Known() {
  Eigen::MatrixXd a(3, 3);
  a << 4.0, 2.0, 0.0, 2.0, 5.0, 1.0, 0.0, 1.0, 3.0;
  return a;
}

double Farthest(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

TEST(LinearSystemsTest, AVectorAndItsColumnHaveTheSameSolution) {
  const Eigen::VectorXd x = Eigen::Vector3d(1.0, -2.0, 0.5);
  const Eigen::VectorXd b = Known() * x;
  EXPECT_LT(Farthest(SolveSymmetric(Known(), b), x), 1e-14);
  EXPECT_LT(Farthest(SolveSymmetric(Known(), Eigen::MatrixXd(b)), x), 1e-14);
}

TEST(LinearSystemsTest, TheInverseOfTheInverseIsTheMatrix) {
  EXPECT_LT(Farthest(InverseOfSymmetric(Known()) * Known(), Eigen::MatrixXd::Identity(3, 3)),
            1e-14);
  EXPECT_LT(Farthest(InverseOfSymmetric(InverseOfSymmetric(Known())), Known()), 1e-13);
}

TEST(LinearSystemsTest, ACoordinateOfWhichNothingIsKnownHasALargeFiniteVariance) {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(2, 2);
  information(0, 0) = 4.0;
  const Eigen::MatrixXd covariance = CovarianceOf(information);
  EXPECT_NEAR(covariance(0, 0), 0.25, 1e-9);
  EXPECT_NEAR(covariance(1, 1), 1e9, 1.0);
  EXPECT_EQ(covariance(0, 1), 0.0);
}

TEST(LinearSystemsTest, TheLogarithmOfADeterminantStopsAtTheSmallestPivot) {
  EXPECT_NEAR(LogDeterminant(Known()), std::log(Known().determinant()), 1e-14);
  Eigen::MatrixXd singular = Eigen::MatrixXd::Zero(2, 2);
  singular(0, 0) = 2.0;
  EXPECT_NEAR(LogDeterminant(singular), std::log(2.0) + std::log(1e-12), 1e-12);
}

TEST(LinearSystemsTest, TheSquareRootExistsWhereRoundingHasMadeTheMatrixIndefinite) {
  const Eigen::MatrixXd root = SquareRootOf(Known());
  EXPECT_LT(Farthest(root * root.transpose(), Known()), 1e-14);
  Eigen::MatrixXd indefinite(2, 2);
  indefinite << 1.0, 1.0, 1.0, 1.0 - 1e-15;
  const Eigen::MatrixXd rounded = SquareRootOf(indefinite);
  ASSERT_TRUE(rounded.allFinite());
  EXPECT_LT(Farthest(rounded * rounded.transpose(), indefinite), 1e-14);
}

TEST(LinearSystemsTest, EqualColumnsShareTheLeastSquares) {
  Eigen::MatrixXd columns(4, 3);
  columns << 1, 1, 0, 1, 1, 1, 1, 1, 2, 1, 1, 3;
  const Eigen::VectorXd b = Eigen::Vector4d(1.0, 3.0, 5.0, 7.0);  // 1 + 2 k
  const Eigen::VectorXd x = LeastSquares(columns, b, 1e-9);
  EXPECT_LT(Farthest(x, Eigen::Vector3d(0.5, 0.5, 2.0)), 1e-13);
}

}  // namespace
}  // namespace faultlab::core
