#pragma once

#include <string>
#include <string_view>

#include "core/bench/bench.h"
#include "core/filter/map_fit.h"
#include "core/filter/rig_parameters.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// How a healthy rig moves while it warms up: random walks of the winding's resistance (0.3 % in
/// one second, 3 % in 100 s), of the motor constant (0.4 times as far) and of the viscous friction
/// (3.3 times), until Ra has moved by BenchNorm::warming. Slow against a fault, which comes at
/// once. Source of the figures: copper changes by 0.4 % per kelvin; a motor at work warms by some
/// kelvin a minute.
///
/// Adds to `prior` what may have happened in so many seconds.
void Widen(const BenchNorm& norm, double seconds, GaussianPrior& prior);

/// Whether warming could be behind this verdict: a small change of Ra, Ke or B, or something that
/// no component explains and that moves one of them.
/// @param moved  LackOfFit::moved
bool MayBeWarming(const Bench& bench, const Verdict& verdict, std::string_view moved);

/// "Ra has moved by +1.7 %, as that of a rig that warms up does"
std::string WarmingSentence(const Eigen::VectorXd& shift);

}  // namespace faultlab::core
