#pragma once

#include <cstdint>

#include "tests/world/rehearsal.h"

namespace faultlab::server::lab::rehearsal {

/// Simulates weeks with the same people three times: with the shipping service on a store in memory
/// and its oracle, with one line for all rigs (first in, first out, no calendar), and with fixed
/// slots given out first in, first out. Fills jain, days_estimate_held, ours, fifo and fifo_slots
/// of the report, and broken_rules.
void SimulateSemester(int weeks, std::uint64_t seed, bool timetable, RehearsalReport& report);

}  // namespace faultlab::server::lab::rehearsal
