#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/isolation/isolation_options.h"
#include "core/types/calibration.h"
#include "core/types/sample.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// When the fault began, estimated from the record around the alarm.
struct Onset {
  double t_s = 0.0;
  bool all_along = false;  ///< the fault covers the whole history
};

/// The task of fitting all hypotheses to the record around an alarm. A self-contained value: move
/// it to any thread and call Isolate.
struct IsolationTask {
  std::uint64_t id = 0;         ///< copied to IsolationResult
  std::vector<Sample> samples;  ///< before and after the alarm
  std::size_t alarm_at = 0;     ///< first sample of `samples` at or after the alarm
  std::size_t fit_from = 0;     ///< first sample that certainly belongs to the fault
  std::shared_ptr<const Calibration> calibration;  ///< never null
  IsolationOptions options;
  std::vector<Candidate> reference;  ///< faults present before this alarm (empty: nominal)
  /// What a settled answer about this alarm has found (empty: there is none yet). It stays until
  /// the newest samples refute it: an input that shows it no longer is no return to nominal.
  std::vector<Candidate> found;
  /// What nothing told apart from the last of them.
  std::vector<Component> alike;
  /// The last of them is a drift that had come to rest.
  bool has_moved = false;
  /// What this alarm's fault was found to be while the motor still turned: while it moved, or the
  /// first that left no more than noise. Empty: nothing yet.
  std::vector<Component> found_turning;
  /// What nothing told apart in this alarm's newest answer of a motor at rest. A longer rest does
  /// not tell it apart either.
  std::vector<Component> alike_at_rest;
  /// True where it is one of them, or nothing was found yet.
  bool AgreesWithFound(Component component) const {
    return found_turning.empty() ||
           std::find(found_turning.begin(), found_turning.end(), component) != found_turning.end();
  }
  double alarm_t_s = 0.0;
  /// The onset, when the samples around it have been dropped; without it the onset is searched for.
  std::optional<Onset> onset;
  std::string detector;
  bool settled = false;  ///< last task of this alarm's schedule
  bool early = false;    ///< of so few samples that only a sure answer counts
};

}  // namespace faultlab::core
