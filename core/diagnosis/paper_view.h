#pragma once

#include <array>

#include "core/diagnosis/diagnosis_options.h"
#include "core/paper/paper_methods.h"
#include "core/types/calibration.h"
#include "core/types/frame.h"

namespace faultlab::core {

/// The paper's methods applied to the newest estimate of the sliding integrals (100, 20), in exact
/// mode. The band is four standard errors, at least 2 % of nominal. Empty while that estimate is
/// invalid.
PaperMethods PaperMethodsAt(const Bench& bench, const Frame& frame, const Calibration& calibration);

/// What each of the six estimators gives on a healthy rig. With `calibration`: for the calibrated
/// rig. Without (null): for the data sheet, with um read at the edge of the input (delta = 0).
std::array<ContinuousTheta, kEstimatorCount> NominalEstimates(const DiagnosisOptions& options,
                                                              const Calibration* calibration);

}  // namespace faultlab::core
