#pragma once

#include <Eigen/Core>
#include <array>

#include "core/filter/prediction_model.h"

namespace faultlab::core {

/// The covariance of the Kalman filter, step by step, for a caller that keeps the state itself:
///   Predict   P <- phi P phi' + Q              (Q: torque_step_variance in the last entry)
///   Correct   S = c P c' + R,  K = P c' / S,  P <- P - K c P      one scalar reading of a channel
/// P is 4 x 4 in the units of PredictionModel's state, S in the squared unit of the reading. The
/// model must outlive this. No allocation.
/// Source: R. E. Kalman, R. S. Bucy, J. Basic Eng. 83 (1961); B. D. O. Anderson, J. B. Moore,
/// Optimal Filtering (1979), sections 3.1 and 4.4.
class RiccatiRecursion {
 public:
  explicit RiccatiRecursion(const PredictionModel& model) : model_(&model) {}

  /// Marks the state as unknown.
  void Restart();
  void Predict();
  /// Adds to what is not known of the speed, (rad/s)^2.
  void WidenSpeed(double variance) { p_(2, 2) += variance; }
  /// Processes one scalar reading: returns S and stores the gain in `gain`.
  double Correct(int channel, Eigen::Vector4d& gain);

 private:
  const PredictionModel* model_;
  Eigen::Matrix4d p_ = Eigen::Matrix4d::Zero();
};

/// Gains of one sample, in the order of the channels.
struct ChannelGains {
  std::array<Eigen::Vector4d, kOutputCount> gain;
  std::array<double, kOutputCount> inverse_sd{};  ///< 1 / sqrt(S); 0 for a channel not in mask
};

/// The gains that the recursion settles at, for channels `mask` (bit c: channel c), after 20 s
/// (2000 steps at least), many times every time constant of the rig. A channel outside `mask` has
/// gain 0.
ChannelGains SteadyStateGains(const PredictionModel& model, unsigned mask);

}  // namespace faultlab::core
