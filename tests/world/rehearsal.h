#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/types/result.h"
#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

struct RehearsalOptions {
  std::int64_t steps = 1'000'000;  ///< random inputs to the real scheduler
  std::uint64_t seed = 1;
  int weeks = 2;  ///< simulated weeks of the comparison; 0: none
  /// In those weeks the lab closes at night, and each of three courses has hours of its own.
  bool timetable = false;
  /// As DatabaseOptions::location: a database whose lab is empty and that is filled and emptied.
  /// Empty: in memory.
  std::string database{};
  std::string until_broken{};  ///< ends when this rule was found broken; empty: it goes on
};

/// The result of one way of sharing the rigs in the simulated weeks.
struct WeekFigures {
  double utilisation = 0.0;      ///< useful rig time divided by rig time in opening hours
  double median_wait_min = 0.0;  ///< from request to start, without bookings for later
  double p95_wait_min = 0.0;
  double no_show_loss = 0.0;  ///< rig time reserved for no-shows / time in opening hours
  double served = 0.0;        ///< requests served divided by requests made
  double jain = 1.0;          ///< as in the report
};

struct RehearsalReport {
  std::int64_t steps = 0;
  std::int64_t double_allocations = 0;  ///< two holders of one rig, or no check between them
  std::int64_t stale_commands_tried = 0;
  std::int64_t stale_commands_accepted = 0;
  std::int64_t broken_invariants = 0;  ///< findings of the oracle about any other rule
  std::string first_broken;            ///< the first finding and its step; empty if none
  struct BrokenRule {
    std::int64_t count = 0;
    std::string first;  ///< with its step and world
  };
  std::map<std::string, BrokenRule> broken_rules;  ///< findings of the oracle
  std::int64_t commands_accepted = 0;
  std::int64_t sessions = 0;
  std::int64_t crashes = 0;
  std::int64_t clock_jumps = 0;
  std::int64_t quarantines = 0;
  double jain = 1.0;  ///< (sum x)^2 / (n sum x^2) of the rig time of equal users under load
  /// Share of simulated days on which nobody waited more than twice the first estimate (and 2 min).
  double days_estimate_held = 1.0;
  WeekFigures ours;
  WeekFigures fifo;        ///< the same people in one line, without a calendar
  WeekFigures fifo_slots;  ///< the same people, served first in, first out, in fixed slots
};

/// Drives the shipping lab service with random people and faults (README.md), judged by the
/// oracle; then simulated weeks. The same options give the same report. An error: the database
/// cannot be used.
core::Result<RehearsalReport> Rehearse(const RehearsalOptions& options);

/// {"steps":..,"double_allocations":..,..,"ours":{..},"fifo_slots":{..}}
std::string ToJson(const RehearsalReport& report);

}  // namespace faultlab::server::lab
