#include "tests/core/estimators/batch_oracle.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>

namespace faultlab::testing {

BatchAnswer SolveBatch(const std::vector<std::vector<double>>& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  const auto p = static_cast<Eigen::Index>(rows.front().size()) - 1;
  Eigen::MatrixXd phi(n, p);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::vector<double>& row = rows[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < p; ++j) {
      phi(i, j) = row[static_cast<std::size_t>(j)];
    }
    y(i) = row[static_cast<std::size_t>(p)];
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(phi);
  const Eigen::VectorXd theta = qr.solve(y);
  const double sse = (y - phi * theta).squaredNorm();
  // (phi' phi)^-1 = P R^-1 R^-T P'
  const Eigen::MatrixXd r = qr.matrixR().topLeftCorner(p, p).triangularView<Eigen::Upper>();
  const Eigen::MatrixXd r_inverse =
      r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(p, p));
  const Eigen::MatrixXd root = qr.colsPermutation() * r_inverse;
  Eigen::MatrixXd unit = phi;
  for (Eigen::Index j = 0; j < p; ++j) {
    unit.col(j).normalize();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(unit);
  const double ratio = svd.singularValues()(0) / svd.singularValues()(p - 1);
  BatchAnswer answer;
  answer.sse = sse;
  answer.sum_of_squares = y.squaredNorm();
  answer.unit_condition = ratio * ratio;
  for (Eigen::Index j = 0; j < p; ++j) {
    answer.theta.push_back(theta(j));
    answer.scale.push_back(y.norm() / phi.col(j).norm());
    answer.sigma.push_back(std::sqrt(sse / static_cast<double>(n - p) * root.row(j).squaredNorm()));
  }
  return answer;
}

}  // namespace faultlab::testing
