#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "core/diagnosis/observation.h"
#include "core/diagnosis/prediction_model.h"

namespace faultlab::core {

/// What a model's innovations over a stretch say.
struct InnovationSummary {
  double chi2 = 0.0;  ///< sum of (e / sqrt(S))^2; its expectation is `count` if the model is right
  double log_det = 0.0;  ///< sum of log S, with the S that the filter settled at
  int count = 0;         ///< scalar readings used
  /// Innovations' response to Mc: chi2(Mc + m) = chi2 - 2 m mc_cross + m^2 mc_square. Only of
  /// RunWithMcResponse.
  double mc_cross = 0.0;
  double mc_square = 0.0;
  std::array<double, kOutputCount> chi2_of{};
  std::array<int, kOutputCount> count_of{};

  double cost() const { return chi2 + log_det; }
};

/// Whitened innovations, kOutputCount for each observation, 0 where there was no reading.
struct InnovationTrace {
  std::vector<double> whitened;
};

/// A model that holds from sample `from` of a stretch on.
struct ModelSegment {
  std::size_t from = 0;
  const PredictionModel* model = nullptr;
  bool uncharged = false;  ///< C8 is switched in, and comes without charge: z = 0
};

/// Runs the Kalman filter of `model` over a stretch from an unknown state (only the friction's
/// deviation has its stationary prior), that is: the initial state is projected out.
///   -2 log p(stretch) = chi2 + log_det + const
/// Readings of one sample are used one after the other, so the innovations are white across
/// channels too. After the gains have settled they are held. A clipped um counts only if the
/// prediction lies inside the rail. `trace`, when given, is resized. Cost 25-60 ns per sample.
InnovationSummary RunInnovations(const PredictionModel& model,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace = nullptr);

/// The same with a model that changes on the way (a fault that sets in, a parameter that drifts);
/// the state is carried over. Contract: segments not empty, the first from sample 0, rising.
using ModelPath = std::span<const ModelSegment>;
InnovationSummary RunInnovations(ModelPath path,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace = nullptr);

/// Whitened innovations side by side: a row for each reading (a channel in a sample's mask, in
/// order), a column for each model.
using InnovationTable = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The same for many paths: sums[i] and column i of `table` have the bits that path i alone gets.
/// `table`, when given, is resized; columns beyond the paths are padding. One filter waits for its
/// own last result all the time; several side by side, and two or four to a register, do not: 8-13
/// ns per sample and path, 20 in the first 100 samples, while the covariance moves (AVX2; half as
/// much again without).
/// Contract: as many sums as paths, at least one.
void RunInnovations(std::span<const ModelPath> paths,
                    std::span<const Observation> stretch,
                    std::span<InnovationSummary> sums,
                    InnovationTable* table = nullptr);
/// With mc_cross and mc_square.
void RunWithMcResponse(std::span<const ModelPath> paths,
                       std::span<const Observation> stretch,
                       std::span<InnovationSummary> sums);

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
