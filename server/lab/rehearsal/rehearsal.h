#pragma once

#include <cstdint>
#include <string>

#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

struct RehearsalOptions {
  std::int64_t steps = 1'000'000;  ///< random inputs to the real scheduler
  std::uint64_t seed = 1;
  int weeks = 2;  ///< simulated weeks of the comparison, 0 = leave it out
};

/// What one way of sharing the rigs did in the simulated weeks.
struct WeekFigures {
  double utilisation = 0.0;      ///< useful rig time over rig time in opening hours
  double median_wait_min = 0.0;  ///< from asking to starting, walk-ups and bookings that ask "now"
  double p95_wait_min = 0.0;
  double no_show_loss = 0.0;  ///< rig time held for nobody over rig time in opening hours
  double served = 0.0;        ///< requests served over requests made
};

struct RehearsalReport {
  std::int64_t steps = 0;
  std::int64_t double_allocations = 0;  ///< two holders of a rig, or a rig handed on unchecked
  std::int64_t stale_commands_tried = 0;
  std::int64_t stale_commands_accepted = 0;
  std::int64_t broken_invariants = 0;
  std::string first_broken;  ///< what and at which step; empty if nothing broke
  std::int64_t commands_accepted = 0;
  std::int64_t sessions = 0;
  std::int64_t crashes = 0;
  std::int64_t clock_jumps = 0;
  std::int64_t quarantines = 0;
  double jain = 1.0;  ///< (sum x)^2 / (n sum x^2) of the rig time that equal users got under load
  /// Share of simulated days on which nobody waited more than twice the first estimate (and 2 min).
  double days_estimate_held = 1.0;
  WeekFigures ours;
  WeekFigures fifo_slots;  ///< the same people, first in first out, fixed slots
};

/// Runs the real scheduler on a fake clock: random inputs with rig failures, lost and failed
/// checks, crashes before and after a commit, clock jumps; then simulated weeks. Same options, same
/// report.
RehearsalReport Rehearse(const RehearsalOptions& options);

/// {"steps":..,"double_allocations":..,..,"ours":{..},"fifo_slots":{..}}
std::string ToJson(const RehearsalReport& report);

}  // namespace faultlab::server::lab
