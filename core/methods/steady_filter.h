#pragma once

#include <Eigen/Core>
#include <cmath>

#include "core/filter/riccati_recursion.h"
#include "core/methods/method.h"

namespace faultlab::core {

/// An observer with a constant gain on the fitted channel:
///   x <- Step(model, x),   e = y - c x - d u,   x <- x + gain e
struct SteadyFilter {
  PredictionModel model;
  Eigen::Vector4d gain = Eigen::Vector4d::Zero();
  double inverse_sd = 1.0;  ///< of e, when the model is right
  Eigen::Vector4d x = Eigen::Vector4d::Zero();

  /// e before the correction; 0 without a reading.
  double Predict(const MethodTask& task, const Observation& o) {
    const double u_prev = model.Limited(o.u_prev);
    const double u = model.Limited(o.u);
    if (o.restart) x = TurningState(model, u_prev);
    const Eigen::Vector4d moved = Step(model, x, u_prev, u);
    x = moved;
    if (!task.Has(o)) return 0.0;
    const int row = task.channel();
    return task.Reading(o) - model.c.row(row).dot(x) - model.d(row) * u;
  }
};

/// The Kalman filter of a model with the gain that it settles at.
inline SteadyFilter SettledKalman(const MethodTask& task, const PredictionModel& model) {
  const auto c = static_cast<std::size_t>(task.channel());
  const ChannelGains gains = SteadyStateGains(model, 1U << c);
  SteadyFilter filter;
  filter.model = model;
  filter.gain = gains.gain[c];
  filter.inverse_sd = gains.inverse_sd[c];
  return filter;
}

}  // namespace faultlab::core
