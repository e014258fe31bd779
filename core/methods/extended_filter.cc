// The extended Kalman filter on state and parameters; see parameter_filter.h.
//   F = [ phi  d Step/d log theta ; 0  I ],   P <- F P F' + Q
//   H = [ c    d (c x + d u)/d log theta ],   K = P H' / (H P H' + R)
#include <Eigen/Core>

#include "core/methods/parameter_filter.h"

namespace faultlab::core {
namespace {
constexpr double kStep = 1e-4;  // of a logarithm, for derivatives
}

void ExtendedFilter::Predict(const Observation& o) {
  const Eigen::Index n = x_.size();
  const PredictionModel model = At(x_);
  const Eigen::Vector4d x = x_.head<4>();
  const Eigen::Vector4d next = Step(model, x, model.Limited(o.u_prev), model.Limited(o.u));
  Eigen::MatrixXd f = Eigen::MatrixXd::Identity(n, n);
  f.topLeftCorner<4, 4>() = model.phi;
  for (Eigen::Index i = 4; i < n; ++i) {
    Eigen::VectorXd moved = x_;
    moved(i) += kStep;
    const PredictionModel other = At(moved);
    const Eigen::Vector4d there = Step(other, x, other.Limited(o.u_prev), other.Limited(o.u));
    f.block<4, 1>(0, i) = (there - next) / kStep;
  }
  const Eigen::MatrixXd spread = f * p_ * f.transpose();
  p_ = spread;
  p_(3, 3) += model.torque_step_variance;
  x_.head<4>() = next;
}

void ExtendedFilter::Correct(const Observation& o) {
  const Eigen::Index n = x_.size();
  const int row = task_.channel();
  const PredictionModel model = At(x_);
  const Eigen::Vector4d x = x_.head<4>();
  const auto output = [&](const PredictionModel& m) {
    return m.c.row(row).dot(x) + m.d(row) * m.Limited(o.u);
  };
  const double predicted = output(model);
  Eigen::VectorXd h(n);
  h.head<4>() = model.c.row(row).transpose();
  for (Eigen::Index i = 4; i < n; ++i) {
    Eigen::VectorXd moved = x_;
    moved(i) += kStep;
    h(i) = (output(At(moved)) - predicted) / kStep;
  }
  const Eigen::VectorXd ph = p_ * h;
  variance_ = h.dot(ph) + model.reading_variance[static_cast<std::size_t>(row)];
  innovation_ = task_.Reading(o) - predicted;
  const Eigen::VectorXd gain = ph / variance_;
  x_ += gain * innovation_;
  p_ -= gain * ph.transpose();
}

}  // namespace faultlab::core
