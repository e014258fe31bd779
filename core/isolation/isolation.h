#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/isolation/fault_shape.h"
#include "core/isolation/isolation_task.h"
#include "core/types/verdict.h"

namespace faultlab::core {

struct IsolationResult {
  std::uint64_t id = 0;
  Verdict verdict;
  FaultShape shape = FaultShape::kAbrupt;
  bool adequate = false;             ///< a fault that leaves no more than noise
  bool moves = false;                ///< a drift that goes on
  bool moved_on = false;             ///< that fault is the known one, which had moved before
  std::optional<Onset> onset;        ///< of an abrupt fault
  bool returned_to_nominal = false;  ///< the record after the alarm is explained without a fault
  /// So it is, but no better than with IsolationTask::found: nothing is to be told.
  bool shows_neither = false;
  /// It is so because the rig has warmed up: it is healthy with its coordinates moved by `shift`.
  bool warmed = false;
  /// The reading that has raised the alarm was left out: nothing but an impulse is that far off.
  bool impulse = false;
  /// The faults that the model must carry from here on to predict the record (one, or two).
  std::vector<Candidate> present;
  /// From which they were estimated.
  std::size_t samples = 0;
  /// Change of the calibration's coordinates in that fit, or in the one without a fault (8, or
  /// none).
  std::vector<double> shift;
  /// The same of the share of the amplifier's gain that acts at once: a factor.
  double direct_factor = 1.0;
  /// Of a fault that brings the motor to rest, where friction is not as modelled: how many times
  /// the noise is to be expected from then on.
  double noise_factor = 1.0;
  bool early = false;  ///< IsolationTask::early
  /// Nothing but what no reading of this kind can tell apart is left beside what is named.
  bool sure = false;
  double gain = 0.0;  ///< cost without a fault minus cost with it, in -2 log probability
};

/// Which component has failed, by how much, and since when: a pure function of the task; any
/// thread. A generalised likelihood ratio among single faults, H0 (no fault) to H7, each with the
/// calibration's eight coordinates as nuisances.
/// No answer: fewer than two samples after the alarm, or a gain below 14, is `returned_to_nominal`;
/// a record that no single component explains is kUnknownFault.
/// CPU time: 3 ms in the median (core/README.md).
/// Source: M. Basseville, I. V. Nikiforov, Detection of Abrupt Changes (1993), sections 2.4
/// and 8.3.
IsolationResult Isolate(const IsolationTask& task);

}  // namespace faultlab::core
