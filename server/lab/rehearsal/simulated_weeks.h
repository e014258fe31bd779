#pragma once

#include <cstdint>

#include "server/lab/rehearsal/rehearsal.h"

namespace faultlab::server::lab {

/// Simulated weeks: the same people, once with the real scheduler, once with fixed slots handed out
/// first in, first out. Both face the same needs, the same no-shows and the same checks. Fills
/// jain, days_estimate_held, ours and fifo_slots of the report.
void SimulateWeeks(int weeks, std::uint64_t seed, RehearsalReport& report);

}  // namespace faultlab::server::lab
