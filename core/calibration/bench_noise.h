#pragma once

#include "core/bench/bench.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// The noise that the description of the bench states, before anything is measured.
NoiseLevel NoiseOf(const Bench& bench);
/// The noise of one simulator of the bench.
NoiseLevel NoiseOf(const BenchProfile& profile, double gear_ratio);

}  // namespace faultlab::core
