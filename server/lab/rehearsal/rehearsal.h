#pragma once

#include <cstdint>
#include <string>

#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

struct RehearsalOptions {
  std::int64_t steps = 1'000'000;  ///< random inputs to the real scheduler
  std::uint64_t seed = 1;
  int weeks = 2;  ///< simulated weeks of the comparison; 0: none
};

/// The result of one way of sharing the rigs in the simulated weeks.
struct WeekFigures {
  double utilisation = 0.0;      ///< useful rig time divided by rig time in opening hours
  double median_wait_min = 0.0;  ///< from request to start, without bookings for later
  double p95_wait_min = 0.0;
  double no_show_loss = 0.0;  ///< rig time reserved for no-shows / time in opening hours
  double served = 0.0;        ///< requests served divided by requests made
};

struct RehearsalReport {
  std::int64_t steps = 0;
  std::int64_t double_allocations = 0;  ///< two holders of one rig, or no check between them
  std::int64_t stale_commands_tried = 0;
  std::int64_t stale_commands_accepted = 0;
  std::int64_t broken_invariants = 0;
  std::string first_broken;  ///< the first broken invariant and its step; empty if none
  std::int64_t commands_accepted = 0;
  std::int64_t sessions = 0;
  std::int64_t crashes = 0;
  std::int64_t clock_jumps = 0;
  std::int64_t quarantines = 0;
  double jain = 1.0;  ///< (sum x)^2 / (n sum x^2) of the rig time of equal users under load
  /// Share of simulated days on which nobody waited more than twice the first estimate (and 2 min).
  double days_estimate_held = 1.0;
  WeekFigures ours;
  WeekFigures fifo_slots;  ///< the same people, served first in, first out, in fixed slots
};

/// Runs the real scheduler on a fake clock: random inputs with rig failures, lost and failed
/// checks, crashes before and after a commit, clock jumps; then simulated weeks. The same options
/// give the same report.
RehearsalReport Rehearse(const RehearsalOptions& options);

/// {"steps":..,"double_allocations":..,..,"ours":{..},"fifo_slots":{..}}
std::string ToJson(const RehearsalReport& report);

}  // namespace faultlab::server::lab
