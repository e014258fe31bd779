#pragma once

#include <span>

#include "core/filter/observation.h"

namespace faultlab::core {

/// How often the input moves at once by more than a twentieth of its swing, or, of one that moves
/// smoothly, how often it has moved as far as its swing. Each gives one piece of information about
/// gain and time constant.
int SwitchesOf(std::span<const Observation> stretch);

/// The least change of the input that is a step (V), of its swing; ModelError::step_v.
double StepOf(std::span<const Observation> stretch);

}  // namespace faultlab::core
