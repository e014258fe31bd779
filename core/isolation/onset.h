#pragma once

#include <cstddef>
#include <span>

#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// First sample of the fault: the k = 1 .. `last` that minimises the chi2 of `stretch` under the
/// model `before` until k and `after` from k on. The state is carried over; with `uncharged`, the
/// capacitor starts without charge at k because it was switched in there. This is the
/// maximum-likelihood estimate of a change time between two known models.
/// No answer: `last` when the stretch has no candidate or no chi2 is finite.
/// Source: D. V. Hinkley, Biometrika 57 (1970).
/// Cost: `last` filters side by side over at most `last` + 20 samples.
std::size_t EstimateOnset(const RigParameters& before,
                          const RigParameters& after,
                          const NoiseLevel& noise,
                          double period_s,
                          bool uncharged,
                          std::span<const Observation> stretch,
                          std::size_t last);

}  // namespace faultlab::core
