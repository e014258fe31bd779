#pragma once

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

/// How the winning parameter moves inside the fitted stretch.
enum class FaultShape { kAbrupt, kDrift };

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
  double alarm_t_s = 0.0;
  /// The onset, when the samples around it have been dropped; without it the onset is searched for.
  std::optional<Onset> onset;
  std::string detector;
  bool settled = false;  ///< last task of this alarm's schedule
};

struct IsolationResult {
  std::uint64_t id = 0;
  Verdict verdict;
  FaultShape shape = FaultShape::kAbrupt;
  std::optional<Onset> onset;        ///< of an abrupt fault
  bool returned_to_nominal = false;  ///< the record after the alarm is explained without a fault
  /// It is so because the rig has warmed up: it is healthy with its coordinates moved by `shift`.
  bool warmed = false;
  std::string moved;  ///< LackOfFit::moved of a record that no component explains
  /// The faults that the model must carry from here on to predict the record (one, or two).
  std::vector<Candidate> present;
  /// Change of the calibration's coordinates in that fit, or in the one without a fault (8, or
  /// none).
  std::vector<double> shift;
  double gain = 0.0;  ///< cost without a fault minus cost with it, in -2 log probability
};

/// Which component has failed, by how much, and since when: a pure function of the task; any
/// thread. A generalised likelihood ratio among single faults, H0 (no fault) to H7, each with the
/// calibration's eight coordinates as nuisances.
/// No answer: fewer than two samples after the alarm, or a gain below 14, is `returned_to_nominal`;
/// a record that no single component explains is kUnknownFault.
/// CPU time (Release, isolation_bench): 3 ms in the median; at worst 15 ms when one component
/// explains the record, 25 ms when none does or the fault moves.
/// Source: M. Basseville, I. V. Nikiforov, Detection of Abrupt Changes (1993), sections 2.4
/// and 8.3.
IsolationResult Isolate(const IsolationTask& task);

}  // namespace faultlab::core
