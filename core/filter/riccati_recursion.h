#pragma once

#include <Eigen/Core>
#include <array>

#include "core/filter/prediction_model.h"

namespace faultlab::core {

/// The covariance side of the same filter, step by step, for whoever runs the state himself.
class GainRecursion {
 public:
  explicit GainRecursion(const PredictionModel& model) : model_(&model) {}

  /// The state is not known (any more).
  void Restart();
  void Predict();
  /// One scalar reading: returns S, leaves the gain.
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

/// The gains that the recursion settles at, for channels `mask`.
ChannelGains Settle(const PredictionModel& model, unsigned mask);

}  // namespace faultlab::core
