// The unscented Kalman filter on state and parameters; see parameter_filter.h.
#include <Eigen/Core>
#include <cmath>

#include "core/methods/parameter_filter.h"
#include "core/numerics/linear_systems.h"

namespace faultlab::core {
namespace {
constexpr double kKappa = 1.0;

double WeightOf(Eigen::Index point, Eigen::Index n) {
  const double all = static_cast<double>(n) + kKappa;
  return point == 0 ? kKappa / all : 0.5 / all;
}
}  // namespace

Eigen::MatrixXd UnscentedFilter::Points() const {
  const Eigen::Index n = x_.size();
  const Eigen::MatrixXd root = std::sqrt(static_cast<double>(n) + kKappa) * SquareRootOf(p_);
  Eigen::MatrixXd points(n, 2 * n + 1);
  points.col(0) = x_;
  for (Eigen::Index i = 0; i < n; ++i) {
    points.col(1 + i) = x_ + root.col(i);
    points.col(1 + n + i) = x_ - root.col(i);
  }
  return points;
}

void UnscentedFilter::Predict(const Observation& o) {
  const Eigen::Index n = x_.size();
  Eigen::MatrixXd points = Points();
  double torque_variance = 0.0;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const PredictionModel model = At(points.col(j));
    const Eigen::Vector4d x = points.col(j).head<4>();
    points.col(j).head<4>() = Step(model, x, model.Limited(o.u_prev), model.Limited(o.u));
    if (j == 0) torque_variance = model.torque_step_variance;
  }
  x_.setZero();
  for (Eigen::Index j = 0; j < points.cols(); ++j) x_ += WeightOf(j, n) * points.col(j);
  p_.setZero();
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const Eigen::VectorXd off = points.col(j) - x_;
    p_ += WeightOf(j, n) * off * off.transpose();
  }
  p_(3, 3) += torque_variance;
}

void UnscentedFilter::Correct(const Observation& o) {
  const Eigen::Index n = x_.size();
  const int row = task_.channel();
  const Eigen::MatrixXd points = Points();
  Eigen::VectorXd outputs(points.cols());
  double noise = 0.0;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const PredictionModel model = At(points.col(j));
    outputs(j) = model.c.row(row).dot(points.col(j).head<4>()) + model.d(row) * model.Limited(o.u);
    if (j == 0) noise = model.reading_variance[static_cast<std::size_t>(row)];
  }
  double mean = 0.0;
  for (Eigen::Index j = 0; j < points.cols(); ++j) mean += WeightOf(j, n) * outputs(j);
  variance_ = noise;
  Eigen::VectorXd cross = Eigen::VectorXd::Zero(n);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const double off = outputs(j) - mean;
    variance_ += WeightOf(j, n) * off * off;
    cross += WeightOf(j, n) * off * (points.col(j) - x_);
  }
  innovation_ = task_.Reading(o) - mean;
  const Eigen::VectorXd gain = cross / variance_;
  x_ += gain * innovation_;
  p_ -= variance_ * gain * gain.transpose();
}

}  // namespace faultlab::core
