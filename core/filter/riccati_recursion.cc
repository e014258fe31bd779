#include "core/filter/riccati_recursion.h"

#include <cmath>

namespace faultlab::core {

void RiccatiRecursion::Restart() {
  const Eigen::Vector3d& sd = model_->start_sd;
  p_ = Eigen::Vector4d(sd(0) * sd(0), sd(1) * sd(1), sd(2) * sd(2), model_->torque_variance)
           .asDiagonal();
}

// P+ = phi P phi' + Q, kept symmetric.
void RiccatiRecursion::Predict() {
  const Eigen::Matrix4d left = model_->phi * p_;
  p_.noalias() = left * model_->phi.transpose();
  p_(3, 3) += model_->torque_step_variance;
  const Eigen::Matrix4d symmetric = 0.5 * (p_ + p_.transpose());
  p_ = symmetric;
}

double RiccatiRecursion::Correct(int channel, Eigen::Vector4d& gain) {
  const Eigen::Vector4d ph = p_ * model_->c.row(channel).transpose();
  const double s =
      model_->c.row(channel).dot(ph) + model_->reading_variance[static_cast<std::size_t>(channel)];
  gain = ph / s;
  p_.noalias() -= gain * ph.transpose();
  return s;
}

ChannelGains SteadyStateGains(const PredictionModel& model, unsigned mask) {
  ChannelGains settled;
  RiccatiRecursion recursion(model);
  recursion.Restart();
  constexpr double kSteps = 2000.0;  // 20 s: many times every time constant of the rig
  const auto steps = static_cast<int>(std::lround(kSteps * model.density));
  for (int k = 0; k < steps; ++k) {
    recursion.Predict();
    for (int channel = 0; channel < kOutputCount; ++channel) {
      const auto c = static_cast<std::size_t>(channel);
      settled.gain[c].setZero();
      if ((mask & (1U << channel)) == 0U) continue;
      settled.inverse_sd[c] = 1.0 / std::sqrt(recursion.Correct(channel, settled.gain[c]));
    }
  }
  return settled;
}

}  // namespace faultlab::core
