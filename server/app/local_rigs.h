#pragma once

#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "server/config.h"
#include "server/run/rig_pool.h"

namespace faultlab::server {

/// A bench of this server and how many rigs of it this server simulates.
struct LocalBench {
  const core::Bench* bench = nullptr;  ///< never null
  BenchSettings settings;
};

/// Reads the descriptions that the settings name; the first is the usual one. Refuses what cannot
/// be read, two benches of one name, and a simulator that a bench does not describe.
core::Result<std::vector<LocalBench>> LoadLocalBenches(const Config& config);

/// Puts the simulated rigs into the pool: "sim-1", .. of the usual bench, "NAME-sim-1", .. of
/// the others; and those that stand for real ones, used by one person at a time: "bench-1", ..,
/// "NAME-bench-1", ...
void AddLocalRigs(RigPool& rig_pool, const Config& config, const std::vector<LocalBench>& benches);

}  // namespace faultlab::server
