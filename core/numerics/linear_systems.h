#pragma once

#include <Eigen/Core>

namespace faultlab::core {

// Linear systems whose size is known only when they are made, n <= 30. Each of Eigen's
// decompositions costs the compiler seconds in every file that names it, so those that several
// files need are here.

/// @param a symmetric and semidefinite, n x n
/// @param b n, or n x m
/// @returns x of a x = b, by L D L' with pivots (Golub and Van Loan, Matrix Computations, 4.2.9)
Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd SolveSymmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// @param a symmetric and semidefinite, n x n: a covariance, or an information matrix
/// @returns its inverse, which is the other of the two
Eigen::MatrixXd InverseOfSymmetric(const Eigen::MatrixXd& a);

/// @param information n x n; coordinates of which nothing is known may have zeros
/// @returns the covariance, n x n; of such a coordinate large, but finite
Eigen::MatrixXd CovarianceOf(Eigen::MatrixXd information);

/// @param a symmetric and semidefinite, n x n
/// @returns log(det a); pivots below 1e-12 count as 1e-12
double LogDeterminant(const Eigen::MatrixXd& a);

/// @param a symmetric and semidefinite, n x n; one that rounding has made indefinite counts as the
///     nearest that is not
/// @returns r of r r' = a, n x n
Eigen::MatrixXd SquareRootOf(const Eigen::MatrixXd& a);

/// @param columns m x n, of any rank
/// @param b m
/// @param rank_tolerance a column whose pivot is smaller than this, times the largest, is left out
/// @returns the shortest x of those that make |columns x - b| smallest, by a complete orthogonal
///     decomposition (Golub and Van Loan, 5.5.2)
Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& columns,
                             const Eigen::VectorXd& b,
                             double rank_tolerance);

}  // namespace faultlab::core
