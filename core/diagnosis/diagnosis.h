#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/diagnosis/calibration.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/diagnosis/isolation.h"
#include "core/diagnosis/paper_methods.h"
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

/// Diagnoses a whole record with the pipeline of a live run, solving its tasks in place.
Diagnosis DiagnoseRecord(std::span<const Sample> samples, const DiagnosisOptions& options);

/// The estimates of a record, in order, once per sample: bit-equal to those of a live run with
/// these options.
void ReplayEstimates(std::span<const Sample> samples,
                     const DiagnosisOptions& options,
                     const std::function<void(const Frame&)>& each);

}  // namespace faultlab::core
