#include "core/numerics/linear_systems.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace faultlab::core {
namespace {

constexpr double kUnknown = 1e-9;
constexpr double kSmallestPivot = 1e-12;

}  // namespace

Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.ldlt().solve(b);
}

Eigen::MatrixXd SolveSymmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.ldlt().solve(b);
}

Eigen::MatrixXd InverseOfSymmetric(const Eigen::MatrixXd& a) {
  return SolveSymmetric(a, Eigen::MatrixXd(Eigen::MatrixXd::Identity(a.rows(), a.rows())));
}

Eigen::MatrixXd CovarianceOf(Eigen::MatrixXd information) {
  information.diagonal().array() += kUnknown;
  return InverseOfSymmetric(information);
}

double LogDeterminant(const Eigen::MatrixXd& a) {
  return a.ldlt().vectorD().cwiseMax(kSmallestPivot).array().log().sum();
}

Eigen::MatrixXd SquareRootOf(const Eigen::MatrixXd& a) {
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(a);
  const Eigen::VectorXd d = ldlt.vectorD().cwiseMax(0.0).cwiseSqrt();
  Eigen::MatrixXd root = ldlt.matrixL();
  root = ldlt.transpositionsP().transpose() * (root * d.asDiagonal()).eval();
  return root;
}

Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& columns,
                             const Eigen::VectorXd& b,
                             double rank_tolerance) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(rank_tolerance);
  decomposition.compute(columns);
  return decomposition.solve(b);
}

}  // namespace faultlab::core
