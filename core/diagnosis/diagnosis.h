#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/isolation/fault_shape.h"
#include "core/paper/paper_methods.h"
#include "core/types/calibration.h"
#include "core/types/frame.h"
#include "core/types/result.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// One stretch of the record in which the rig was not nominal.
struct FaultEpisode {
  Verdict verdict;  ///< the last verdict of the episode
  FaultShape shape = FaultShape::kAbrupt;
  std::optional<double> ended_at_s;  ///< return to nominal, or the next fault
};

/// How well a model's simulated output follows um, in percent, computed as by MATLAB's compare.
struct FitPercent {
  std::string model;  ///< "nominal", "isolated"; server adds "swa", "sia", "model_mc_.."
  double percent = 0.0;
};

/// Everything that is known about a record. `diagnose --json` prints it; the program that read the
/// file adds file, samples, period and channels.
struct Diagnosis {
  Verdict verdict;  ///< of the last fault, or of the last state if there was none
  std::optional<Calibration> calibration;              ///< absent when the calibration was refused
  std::optional<Error> calibration_refusal;            ///< why there is no calibration
  std::array<Estimate<3>, kEstimatorCount> estimates;  ///< at the end of the record
  std::array<ContinuousTheta, kEstimatorCount> nominal_estimates{};  ///< on a healthy rig
  std::vector<FitPercent> fit_percent;
  PaperMethods paper;                  ///< from the sliding integrals (100, 20), exact mode
  std::vector<FaultEpisode> episodes;  ///< in time order
};

/// The episodes; of a diagnosis that has none listed, its verdict as the only one.
inline std::vector<FaultEpisode> EpisodesOf(const Diagnosis& diagnosis) {
  if (!diagnosis.episodes.empty() || !diagnosis.verdict.detected_at_s) return diagnosis.episodes;
  return {{diagnosis.verdict, FaultShape::kAbrupt, std::nullopt}};
}

/// Since when the rig is as it is at the end of the record; nothing when it never changed.
inline std::optional<double> NewestChange(const Diagnosis& diagnosis) {
  const std::optional<double> fault = NewestChange(diagnosis.verdict);
  if (fault || diagnosis.episodes.empty()) return fault;
  return diagnosis.episodes.back().ended_at_s;
}

}  // namespace faultlab::core
