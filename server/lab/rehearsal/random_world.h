#pragma once

#include <cstdint>

#include "server/lab/rehearsal/rehearsal.h"

namespace faultlab::server::lab {

/// `steps` random inputs into the real scheduler, in worlds of 1 to 8 rigs that change every 20 000
/// steps. Fills steps, double_allocations .. quarantines of the report.
void RunRandomWorlds(std::int64_t steps, std::uint64_t seed, RehearsalReport& report);

}  // namespace faultlab::server::lab
