#pragma once

#include <cstddef>
#include <span>

#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// First sample of the fault: the switch from `before` to `after` that makes `stretch` likeliest,
/// the state carried over (C8 `uncharged`, if it is the part that was switched). Candidates are
/// samples 1 .. `last`. Cost: `last` filters side by side over at most `last` + 20 samples.
std::size_t EstimateOnset(const RigParameters& before,
                          const RigParameters& after,
                          const NoiseLevel& noise,
                          double period_s,
                          bool uncharged,
                          std::span<const Observation> stretch,
                          std::size_t last);

}  // namespace faultlab::core
