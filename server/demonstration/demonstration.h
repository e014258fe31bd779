#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/fault.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// A short recording to learn from: the usual simulator of a bench, its own excitation, one seed.
/// The same bench and changes give the same samples, so that two recordings differ by the changes
/// alone.
struct Demonstration {
  std::vector<core::Sample> samples;
  std::size_t fault_at = 0;  ///< index of the first sample with the changes
};

/// How much is healthy, and how much comes after the changes, in samples.
struct DemonstrationLength {
  std::size_t healthy = 1000;
  std::size_t faulty = 1000;
};

/// Components and their values at the same moment, "R9:33000,R12:5600"; empty: nothing changes.
/// kInvalid with field "changes": an unknown component, one named twice, a value that is not above
/// 0 or farther than a factor of 1e9 from nominal.
core::Result<std::vector<core::Fault>> ParseChanges(std::string_view text,
                                                    const core::Bench& bench);

/// @param changes  of ParseChanges; their times are set here
/// kInvalid for a bench without a simulator. Cost: about 1 us a sample.
core::Result<Demonstration> PlayDemonstration(const core::Bench& bench,
                                              std::vector<core::Fault> changes,
                                              DemonstrationLength length);

/// Nominal, with these changes.
core::PlantParameters ChangedPlant(const core::Bench& bench,
                                   const std::vector<core::Fault>& changes);

}  // namespace faultlab::server
