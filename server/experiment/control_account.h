#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/calibration/visible_changes.h"
#include "core/control/control_quality.h"
#include "server/experiment/control_json.h"
#include "server/experiment/recordings.h"

namespace faultlab::server {

/// What the drive made up for.
struct Compensation {
  double t_s = 0.0;
  core::Component component{};
  double value = 0.0;  ///< SI
  std::optional<double> until_s{};
  std::string ended;  ///< why; empty: by a newer value, or not at all
};

/// What became of the speed control of a run. Samples by index.
struct ControlAccount {
  PlannedControl planned;
  double period_s = 0.01;
  std::size_t size = 0;  ///< samples, those that are missing included
  std::size_t reference_from = 0;
  std::optional<std::size_t> began{};
  std::size_t judged_from = 0;  ///< the first fault; without one 4.5 s after the reference began
  std::vector<double> reference_rad_s{};  ///< of each sample; NaN before it begins
  double rad_per_s = 1.0;                 ///< of the motor shaft, for 1 rpm of n
  std::vector<Compensation> compensations{};
  /// The highest speed that the rig, as the diagnosis has it, settles at; nothing: not learnt.
  std::optional<double> reachable_rad_s{};
  /// Standard deviation that the dither after an alarm makes of the speed.
  std::optional<double> dither_rad_s{};
  /// What would raise an alarm under this reference, of the healthy rig; empty: too short to tell.
  std::vector<core::VisibleChange> visible{};
};

/// Nothing of a run that was played without speed control.
std::optional<ControlAccount> AccountOf(const Review& review);

/// Nothing while there is nothing to judge.
std::optional<core::ControlQuality> QualityOf(const ControlAccount& account,
                                              std::span<const core::Sample> samples);

/// The run once more on its simulator, with the controller of the healthy rig and no diagnosis;
/// nothing where that cannot be, or would tell hidden faults.
std::optional<std::vector<core::Sample>> WithoutDiagnosis(const ControlAccount& account,
                                                          const Review& review);

}  // namespace faultlab::server
