#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/bench/profile.h"
#include "core/types/fault.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// One run of a simulated rig, as its converters read it. At t_k = k T faults act and uc(k) is
/// written (through the 16-bit converter); at t_k + delta um(k), ua(k), ia(k), n(k) are read. The
/// plant starts at rest. The same arguments give the same bits. Contract: 0 < delta < period,
/// finite uc.
std::vector<Sample> SimulateRecord(const BenchProfile& profile,
                                   const PlantParameters& parameters,
                                   std::span<const double> uc_v,
                                   std::span<const Fault> faults,
                                   std::uint64_t seed,
                                   double period_s);

}  // namespace faultlab::core
