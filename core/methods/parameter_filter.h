#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/methods/method.h"

namespace faultlab::core {

/// What the extended and the unscented Kalman filter share: state and parameters together,
///   X = (z, i, w, d, log theta_1 .. log theta_p),    log theta(k+1) = log theta(k) + walk e(k)
///   x(k+1) = Step(model(theta), x(k)),   y(k) = c(theta) x(k) + d(theta) u(k) + noise
/// with the exact sampled model of each theta (core/filter/prediction_model.h). Logarithms of the
/// values are kept inside the range in which a diagnosis searches.
struct ParameterFilterSetup {
  std::vector<Component> components;  ///< p
  Eigen::VectorXd log_values;         ///< [p] start
  double log_sd = 1.0;                ///< of each at the start
  double walk = 0.003;                ///< per sample, of a logarithm
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  Eigen::Matrix4d p = Eigen::Matrix4d::Identity();
};

/// The model at these values, and where it does not change on the way.
PredictionModel ModelOf(const MethodTask& task,
                        const std::vector<Component>& components,
                        const Eigen::Ref<const Eigen::VectorXd>& log_values);

/// A filter over state and parameters.
class ParameterFilter {
 public:
  ParameterFilter(const MethodTask& task, const ParameterFilterSetup& setup);
  virtual ~ParameterFilter() = default;

  /// One observation further; a sample without a reading is only predicted.
  void Push(const Observation& o);

  const Eigen::VectorXd& x() const { return x_; }
  const Eigen::MatrixXd& p() const { return p_; }
  const std::vector<Component>& components() const { return components_; }
  double LogValue(std::size_t i) const { return x_(4 + static_cast<Eigen::Index>(i)); }
  /// Of the newest reading: innovation and its variance.
  double innovation() const { return innovation_; }
  double variance() const { return variance_; }
  /// Adds `log_sd`^2 to the variance of every parameter.
  void Doubt(double log_sd);
  std::size_t bytes() const;

 protected:
  virtual void Predict(const Observation& o) = 0;
  virtual void Correct(const Observation& o) = 0;
  PredictionModel At(const Eigen::Ref<const Eigen::VectorXd>& augmented) const;
  void Clamp();

  const MethodTask& task_;
  std::vector<Component> components_;
  std::vector<double> log_low_;
  std::vector<double> log_high_;
  double walk_;
  Eigen::VectorXd x_;
  Eigen::MatrixXd p_;
  double innovation_ = 0.0;
  double variance_ = 1.0;
};

/// Extended: derivatives by differences of the model over 1e-4 of a logarithm; friction's switch at
/// low speed is not differentiated.
/// Source: L. Ljung, IEEE Trans. Autom. Control 24 (1979): joint estimation by the EKF.
class ExtendedFilter : public ParameterFilter {
 public:
  using ParameterFilter::ParameterFilter;

 protected:
  void Predict(const Observation& o) override;
  void Correct(const Observation& o) override;
};

/// Unscented: 2n + 1 points X +- sqrt(n + 1) columns of the Cholesky factor, weights 1/(n+1) and
/// 1/(2(n+1)); drawn anew for the reading.
/// Source: S. J. Julier, J. K. Uhlmann, Proc. IEEE 92 (2004), with kappa = 1.
class UnscentedFilter : public ParameterFilter {
 public:
  using ParameterFilter::ParameterFilter;

 protected:
  void Predict(const Observation& o) override;
  void Correct(const Observation& o) override;

 private:
  Eigen::MatrixXd Points() const;
};

}  // namespace faultlab::core
