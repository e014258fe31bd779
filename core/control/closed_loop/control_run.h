#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/bench/bench.h"
#include "core/control/control_quality.h"
#include "core/control/speed_reference.h"
#include "core/control/tolerant_drive.h"
#include "core/types/fault.h"
#include "core/types/result.h"
#include "core/types/sample.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// Speed control of a simulated rig: first the bench's usual input, from which the pipeline learns
/// the healthy rig, then the reference.
struct ControlPlan {
  const Bench* bench = nullptr;  ///< never null; measures n
  std::vector<Fault> faults;
  /// What the control is told from `at_s` on, instead of what the pipeline finds: a diagnosis that
  /// may be wrong.
  std::optional<Fault> told{};
  ToleranceOptions options;
  SpeedReference reference;
  double duration_s = 30.0;
  std::uint64_t seed = 1;
};

struct ControlRecord {
  std::vector<Sample> samples;
  std::vector<double> reference_rad_s;  ///< NaN while the rig is learnt
  std::vector<double> speed_rad_s;      ///< true, at the end of each period
  double control_from_s = 0.0;
  std::optional<double> compensated_at_s;
  std::optional<double> gave_up_at_s;  ///< the speed refuted the diagnosis
  bool accommodated = false;     ///< the reference can be reached with what is known of the rig
  double reachable_rad_s = 0.0;  ///< the highest speed that can
  double dither_rad_s = 0.0;     ///< standard deviation that the dither makes of a healthy speed
  Verdict verdict;
  /// From the first fault on (without one: from 4.5 s after the control began); of the true speed.
  ControlQuality quality;
};

/// Refuses (kInvalid, `field`) a bench without n, a reference that Validate refuses, more than an
/// hour, a reference beyond what the healthy rig reaches, and a rig that could not be learnt.
/// Drives the plant, the converters and the pipeline that simulators and diagnoses use.
Result<ControlRecord> RunControl(const ControlPlan& plan);

}  // namespace faultlab::core
