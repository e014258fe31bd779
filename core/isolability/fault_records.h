#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/filter/innovations.h"
#include "core/filter/observation.h"
#include "core/filter/prediction_model.h"
#include "core/isolability/isolability_options.h"

namespace faultlab::core {

/// Smallest number of input samples before the fault begins.
inline constexpr int kHistorySamplesMin = 10;

/// Noise-free records of a rig whose fault begins at the start of the last `window_samples` of the
/// input, and their distances from a model:
///   D(record, model) = 1/2 sum over the window of |S^-1/2 (y - yhat)|^2      in nats
/// with yhat and S of the model's Kalman filter, which runs on the healthy model until the onset.
/// Contract: options that AnalyseIsolability accepts; they must outlive this.
class FaultRecords {
 public:
  /// How much of the input before the fault is played.
  enum class History {
    kSettling,  ///< as much as the filter needs to forget its unknown initial state
    kAll,
  };
  explicit FaultRecords(const IsolabilityOptions& options, History history = History::kSettling);

  /// The sample at which the fault begins.
  std::size_t onset() const { return onset_; }

  /// @param value  SI unit of the component
  PredictionModel ModelWith(Component component, double value) const;
  const PredictionModel& healthy() const { return healthy_; }
  const std::vector<Observation>& healthy_record() const { return healthy_record_; }

  /// The record of a rig that is healthy until the onset and follows `model` from there on.
  std::vector<Observation> MeanRecord(const PredictionModel& model) const;
  /// D(record, model).
  double Distance(const std::vector<Observation>& record, const PredictionModel& model) const;
  /// The filter's whitened errors inside the window, kOutputCount for each sample.
  std::vector<double> WhitenedWindow(const std::vector<Observation>& record,
                                     const PredictionModel& model) const;

 private:
  PredictionModel ModelOf(const RigParameters& rig) const;

  const IsolabilityOptions& options_;
  std::uint8_t mask_;  ///< channels that are read
  std::span<const double> uc_v_;
  std::size_t onset_ = 0;
  PredictionModel healthy_;
  std::vector<Observation> healthy_record_;
};

}  // namespace faultlab::core
