#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/isolation/isolation.h"
#include "core/paper/paper_methods.h"
#include "core/types/calibration.h"
#include "core/types/frame.h"
#include "core/types/result.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// One stretch of the record that was not nominal.
struct FaultEpisode {
  Verdict verdict;  ///< the last one of the episode
  FaultShape shape = FaultShape::kAbrupt;
  std::optional<double> ended_at_s;  ///< return to nominal, or the next fault
};

/// How well a model's simulated output follows um, in percent, as MATLAB's compare.
struct FitPercent {
  std::string model;  ///< "nominal", "isolated"; server adds "swa", "sia", "model_mc_.."
  double percent = 0.0;
};

/// Everything that is known about a record: the JSON of `diagnose --json` (file, samples, period
/// and channels are added by whoever read the file).
struct Diagnosis {
  Verdict verdict;                           ///< of the record: its last fault, else its last state
  std::optional<Calibration> calibration;    ///< absent when refused
  std::optional<Error> calibration_refusal;  ///< why there is none
  std::array<Estimate<3>, kEstimatorCount> estimates;                ///< at the end of the record
  std::array<ContinuousTheta, kEstimatorCount> nominal_estimates{};  ///< what a healthy rig gives
  std::vector<FitPercent> fit_percent;
  PaperMethods paper;                  ///< from the sliding integrals (100, 20), exact mode
  std::vector<FaultEpisode> episodes;  ///< in time order
};

}  // namespace faultlab::core
