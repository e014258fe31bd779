#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/bench/bench.h"
#include "core/calibration/model_scope.h"
#include "core/filter/rig_parameters.h"
#include "core/types/calibration.h"
#include "core/types/plant_parameters.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::core {

struct CalibrationOptions {
  const Bench* bench = nullptr;  ///< the description of the rig; never null
  PlantParameters data_sheet;    ///< usually bench->nominal
  Channels channels = Channels::kAll;
  double period_s = 0.01;
  double false_alarms_per_day = 1.0;
  double um_rail_v = 10.0;  ///< converter range; a reading at its end is only a bound
  ModelScope model = ModelScope::kAsDescribed;
};

/// Unit of the coordinate Mc (RigParameters::mc_unit_nm) on rigs of this bench.
double McUnitOf(const Bench& bench);
/// What is known of a rig before anything is measured: one standard deviation of each Coordinate; 0
/// holds it at the data sheet.
ParameterOffsets TolerancesOf(const Bench& bench);

/// Calibrates on samples that the caller knows to be fault-free and past the start-up.
///   maximises  log p(samples | q) + log p(q)   over q = {k, R1, Ra, J, B, Ke, Mc, delta, noise}
/// and, on benches that state their tolerances, La and the amplifier's lag,
/// where p(samples | q) is the innovation form (Kalman filter) of the exact sampled model and p(q)
/// the data sheet's tolerances (5 %; delta flat in [0, period], or within 0.1 ms of the mean of
/// Sample::delta_s where most samples carry it).
/// Cost: 5-50 ms; allocates. Refuses (Error.field names the check) a stretch that is too short, not
/// exciting, saturated, or not healthy: parameters far outside tolerance, residual not stationary,
/// noise too large.
/// Source: maximum a posteriori estimation in the innovation form, L. Ljung, System Identification,
/// 2nd ed. (1999), sections 7.4 and 7.5; symbols: core/README.md.
/// A refusal because the stretch does not fit ends with what is wrong with the record, where that
/// can be told (usual_suspects.h); finding out takes up to twenty times as long.
Result<Calibration> Calibrate(std::span<const Sample> samples, const CalibrationOptions& options);
/// Does the stretch pass all checks? Without a look for what is wrong if it does not.
bool Fits(std::span<const Sample> samples, const CalibrationOptions& options);
/// What is wrong with a record that does not fit its bench; nothing if that cannot be told, or if
/// it fits.
std::optional<std::string> WhatIsWrong(std::span<const Sample> samples,
                                       const CalibrationOptions& options);

}  // namespace faultlab::core
