#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/filter/observation.h"
#include "core/filter/prediction_model.h"

namespace faultlab::core {

/// Summary of a model's innovations over a stretch.
struct InnovationSummary {
  double chi2 = 0.0;  ///< sum of (e / sqrt(S))^2; its expectation is `count` if the model is right
  double log_det = 0.0;  ///< sum of log S, with the S at which the filter settled
  int count = 0;         ///< scalar readings used
  /// Response of the innovations to Mc: chi2(Mc + m) = chi2 - 2 m mc_cross + m^2 mc_square. Only
  /// RunWithMcResponse fills it.
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

/// Whitened innovations side by side: a row for each reading (a channel in a sample's mask, in
/// order), a column for each model.
using InnovationTable = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A model that holds from sample `from` of a stretch on.
struct ModelSegment {
  std::size_t from = 0;
  const PredictionModel* model = nullptr;
  bool uncharged = false;  ///< C8 is connected at this point and is not yet charged: z = 0
};

/// The models of a stretch, one after the other.
using ModelPath = std::span<const ModelSegment>;

}  // namespace faultlab::core
