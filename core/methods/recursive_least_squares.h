#pragma once

#include <Eigen/Core>

#include "core/methods/regression.h"

namespace faultlab::core {

/// Least squares with exponential forgetting:
///   K = P phi / (lambda + phi' P phi),  theta <- theta + K (y - phi' theta),
///   P <- (P - K phi' P) / lambda
/// theta minimises  lambda^n (theta - theta0)' P0^-1 (theta - theta0) + sum lambda^(n-k) e(k)^2.
/// No allocation. Source: L. Ljung, System Identification, 2nd ed. (1999), section 11.2.
class RecursiveLeastSquares {
 public:
  RecursiveLeastSquares(const EquationVector& theta, const EquationMatrix& p, double lambda)
      : theta_(theta), p_(p), lambda_(lambda) {}

  /// Returns the error of the prediction before the update.
  double Push(const EquationRow& row) {
    const EquationVector phi = row.head<kEquationParameters>();
    const EquationVector p_phi = p_ * phi;
    const EquationVector gain = p_phi / (lambda_ + phi.dot(p_phi));
    const double error = row(kEquationParameters) - phi.dot(theta_);
    theta_ += gain * error;
    const EquationMatrix updated = (p_ - gain * p_phi.transpose()) / lambda_;
    p_ = 0.5 * (updated + updated.transpose());
    return error;
  }
  /// Everything before is doubted: P is replaced.
  void Reset(const EquationMatrix& p) { p_ = p; }

  const EquationVector& theta() const { return theta_; }
  const EquationMatrix& p() const { return p_; }

 private:
  EquationVector theta_;
  EquationMatrix p_;
  double lambda_;
};

}  // namespace faultlab::core
