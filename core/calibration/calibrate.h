#pragma once

#include <span>

#include "core/types/calibration.h"
#include "core/types/plant_parameters.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::core {

struct CalibrationOptions {
  PlantParameters data_sheet;
  Channels channels = Channels::kAll;
  double period_s = kSamplePeriodSeconds;
  double false_alarms_per_day = 1.0;
  double um_rail_v = 10.0;  ///< converter range: a reading there is a bound, not a value
};

/// Calibrates on samples that the caller holds to be fault-free and past the start-up.
///   maximises  log p(samples | q) + log p(q)   over q = {k, R1, Ra, J, B, Ke, Mc, delta, noise}
/// where p(samples | q) is the innovation form (Kalman filter) of the exact sampled model and p(q)
/// the data sheet's tolerances (5 %; delta flat in [0, period]).
/// Cost: 5-50 ms; allocates. Refuses (Error.field names the check) a stretch that is too short, not
/// exciting, saturated, or not healthy: parameters far outside tolerance, residual not stationary,
/// noise too large.
/// Source: maximum a posteriori estimation in the innovation form, L. Ljung, System Identification,
/// 2nd ed. (1999), sections 7.4 and 7.5; symbols: core/README.md.
Result<Calibration> Calibrate(std::span<const Sample> samples, const CalibrationOptions& options);

}  // namespace faultlab::core
