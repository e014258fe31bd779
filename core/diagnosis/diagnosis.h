#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/diagnosis/calibration.h"
#include "core/diagnosis/isolation.h"
#include "core/diagnosis/paper_methods.h"
#include "core/types/frame.h"
#include "core/types/plant_parameters.h"
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

struct DiagnoseOptions {
  PlantParameters nominal;                 ///< data sheet
  std::optional<Calibration> calibration;  ///< stored with the rig; else learnt from the record
  double healthy_from_s = 0.5;             ///< [from, to) of the record is fault-free
  double healthy_to_s = 5.0;
  Channels channels = Channels::kAll;
  ValuePrior values = ValuePrior::kTable2;
  bool motor_faults = true;
  double period_s = kSamplePeriodSeconds;
  double false_alarms_per_day = 1.0;
};

/// Diagnoses a whole record with the pipeline of a live run, solving its tasks in place.
Diagnosis DiagnoseRecord(std::span<const Sample> samples, const DiagnoseOptions& options);

}  // namespace faultlab::core
