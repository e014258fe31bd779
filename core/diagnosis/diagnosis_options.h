#pragma once

#include <algorithm>
#include <optional>

#include "core/calibration/model_scope.h"
#include "core/estimators/estimator_bank.h"
#include "core/isolation/isolation_options.h"
#include "core/types/calibration.h"
#include "core/types/check.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// What a diagnosis assumes about its rig and its record. One value is stored with a run and is
/// used by its live diagnosis, its figures, its exports and later repairs.
struct DiagnosisOptions {
  const Bench* bench = nullptr;            ///< the description of the rig; never null
  PlantParameters nominal;                 ///< data sheet of the rig, usually bench->nominal
  std::optional<Calibration> calibration;  ///< stored with the rig; absent: from the record
  double healthy_from_s = 0.5;  ///< [from, to) is taken as fault-free when no calibration is stored
  double healthy_to_s = 5.0;
  Channels channels = Channels::kAll;
  ValuePrior values = ValuePrior::kNone;
  bool motor_faults = true;  ///< can Ra, J, B change on this rig?
  double period_s = 0.01;
  double false_alarms_per_day = 1.0;
  double um_rail_v = 10.0;  ///< converter range; a reading at its end is only a bound
  ModelScope model = ModelScope::kAsDescribed;
};

/// The options that follow from the description of a bench, for samples of this period.
inline DiagnosisOptions OptionsOf(const Bench& bench, double period_s) {
  DiagnosisOptions options;
  options.bench = &bench;
  options.nominal = bench.nominal;
  options.period_s = period_s;
  // Slow samples need longer until they are as many as a calibration asks for.
  constexpr double kHealthySamples = 200.0;
  options.healthy_to_s =
      std::max(options.healthy_to_s, options.healthy_from_s + kHealthySamples * period_s);
  options.um_rail_v = bench.um.exists ? bench.um.max : 10.0;
  return options;
}
inline DiagnosisOptions OptionsOf(const Bench& bench) {
  return OptionsOf(bench, bench.period_s);
}

/// The usual healthy stretch of a record whose clock shows `first_s` in its first row: it counts
/// from there.
inline void CountFrom(double first_s, DiagnosisOptions& options) {
  options.healthy_from_s += first_s;
  options.healthy_to_s += first_s;
}

/// The estimators of a diagnosis with these options. Their estimates depend on the samples alone,
/// so a recording pushed through such a bank gives the live run's estimates to the last bit.
inline EstimatorBankOptions BankOptions(const DiagnosisOptions& options) {
  LAB_CHECK(options.bench != nullptr);
  const Bench& bench = *options.bench;
  const EstimatedChannel channel = bench.structure->estimated;
  const double rail = channel == EstimatedChannel::kUm   ? options.um_rail_v
                      : channel == EstimatedChannel::kIa ? bench.ia.max
                                                         : bench.n.max;
  return {
      .period_s = options.period_s,
      .of_row_before = bench.follows_row_before(),
      .delta_s = bench.ReadingDelay(std::min(bench.delta_s, options.period_s), options.period_s),
      .channel = channel,
      .rail = rail};
}

}  // namespace faultlab::core
