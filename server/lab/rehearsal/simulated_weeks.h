#pragma once

#include <cstdint>

#include "server/lab/rehearsal/rehearsal.h"

namespace faultlab::server::lab {

/// Simulates weeks with the same people twice: once with the real scheduler, once with fixed slots
/// given out first in, first out. Both have the same requests, no-shows and checks. Fills jain,
/// days_estimate_held, ours and fifo_slots of the report.
void SimulateWeeks(int weeks, std::uint64_t seed, RehearsalReport& report);

}  // namespace faultlab::server::lab
