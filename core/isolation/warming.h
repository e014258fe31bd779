#pragma once

#include <string>

#include "core/bench/bench.h"
#include "core/filter/map_fit.h"
#include "core/filter/rig_parameters.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// How a healthy rig moves while it warms up: random walks of the winding's resistance (0.3 % in
/// one second, 3 % in 100 s), of the motor constant (0.4 times as far) and of the viscous friction
/// (3.3 times), until the winding has moved by BenchNorm::warming. Slow against a fault, which
/// comes at once. Source of the figures: copper changes by 0.4 % per kelvin; a motor at work warms
/// by some kelvin a minute.
///
/// Adds to `prior` what may have happened in so many seconds.
void Widen(const BenchNorm& norm, double seconds, GaussianPrior& prior);

/// Whether a change of Ra, Ke or B alone is as small as warming may make it.
/// @param healthy  the rig as it was learnt
bool IsWithinWarming(const BenchNorm& norm,
                     const PlantParameters& healthy,
                     const Candidate& candidate);

/// "the winding has moved by +1.7 %, as that of a rig that warms up or runs in does"
std::string WarmingSentence(const Eigen::VectorXd& shift);

}  // namespace faultlab::core
