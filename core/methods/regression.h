#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "core/methods/method.h"

namespace faultlab::core {

/// Parameters of a linear equation between input and output, with a constant for friction.
inline constexpr int kEquationParameters = 4;
using EquationVector = Eigen::Matrix<double, kEquationParameters, 1>;
using EquationMatrix = Eigen::Matrix<double, kEquationParameters, kEquationParameters>;
/// phi, then the right-hand side: y(k) = phi(k)' theta.
using EquationRow = Eigen::Matrix<double, kEquationParameters + 1, 1>;
using RowMoments = Eigen::Matrix<double, kEquationParameters + 1, kEquationParameters + 1>;

/// Makes the rows of a linear equation from input and output, one sample at a time.
class Equation {
 public:
  virtual ~Equation() = default;
  /// False: not enough samples since the restart.
  virtual bool Push(double u, double y, EquationRow& row) = 0;
  virtual void Restart() = 0;
  /// What white noise of y, variance 1, adds to the expectation of row row'.
  virtual RowMoments NoiseMoments() const = 0;
  virtual std::size_t bytes() const = 0;
};

/// The discrete model of first order with a constant (paper Eq. (8)):
///   y(k) = b0d u(k) + b1d u(k-1) - a1d y(k-1) + c
class DiscreteEquation : public Equation {
 public:
  bool Push(double u, double y, EquationRow& row) override;
  void Restart() override { started_ = false; }
  RowMoments NoiseMoments() const override;
  std::size_t bytes() const override { return sizeof *this; }

 private:
  bool started_ = false;
  double u_ = 0.0;
  double y_ = 0.0;
};

/// Sums of row row' and the least squares from them.
struct NormalSums {
  RowMoments sum = RowMoments::Zero();
  double rows = 0.0;

  void Add(const EquationRow& row) {
    sum.noalias() += row * row.transpose();
    rows += 1.0;
  }
  EquationMatrix information() const {
    return sum.topLeftCorner<kEquationParameters, kEquationParameters>();
  }
  EquationVector Solve() const;
  /// Variance of the equation error at `theta`.
  double ErrorVariance(const EquationVector& theta) const;
};

/// The information of (b0, b1, a1) alone: the constant is not known. Schur complement.
Eigen::Matrix3d WithoutConstant(const EquationMatrix& information);

/// What least squares on an equation gives for a rig with another value of a component: the
/// equation fitted to noise-free outputs of the exact model under the input of the healthy stretch,
/// with the expected noise added to the moments. The bias of an equation (noise, reduced order,
/// derivative filters) is then in both sides of a comparison and cancels. Source: indirect
/// inference, C. Gourieroux, A. Monfort, E. Renault, J. Appl. Econometrics 8 (1993).
class CoefficientMap {
 public:
  CoefficientMap(const MethodTask& task, std::unique_ptr<Equation> equation);

  const EquationVector& healthy() const { return healthy_; }
  EquationVector At(Component component, double log_value);

  /// Every component with the value whose coefficients are nearest to `theta`:
  ///   cost = (theta - At(value))' information (theta - At(value)),   without the constant
  MethodFinding Match(const EquationVector& theta, const Eigen::Matrix3d& information);

 private:
  EquationVector Fit(const PredictionModel& model);

  const MethodTask& task_;
  std::unique_ptr<Equation> equation_;
  std::vector<double> u_;
  EquationVector healthy_;
  std::vector<std::vector<EquationVector>> scans_;  ///< by component and point; made when needed
};

}  // namespace faultlab::core
