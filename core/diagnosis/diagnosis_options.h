#pragma once

#include <optional>

#include "core/estimators/estimator_bank.h"
#include "core/isolation/isolation_options.h"
#include "core/types/calibration.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// What a diagnosis assumes about its rig and its record. Live runs, figures, exports and later
/// repairs of one run share one value: it is stored with the run.
struct DiagnosisOptions {
  PlantParameters nominal;                 ///< data sheet of the rig
  std::optional<Calibration> calibration;  ///< stored with the rig; else learnt from the record
  double healthy_from_s = 0.5;  ///< [from, to) is taken as fault-free when nothing is stored
  double healthy_to_s = 5.0;
  Channels channels = Channels::kAll;
  ValuePrior values = ValuePrior::kNone;
  bool motor_faults = true;  ///< can Ra, J, B change on this rig?
  double period_s = kSamplePeriodSeconds;
  double false_alarms_per_day = 1.0;
  double um_rail_v = 10.0;  ///< converter range: a reading there is a bound, not a value
};

/// The estimators of a diagnosis with these options. Their estimates depend on the samples alone,
/// so a recording pushed through such a bank gives the live run's estimates to the last bit.
inline EstimatorBankOptions BankOptions(const DiagnosisOptions& options) {
  return {.period_s = options.period_s, .um_rail_v = options.um_rail_v};
}

}  // namespace faultlab::core
