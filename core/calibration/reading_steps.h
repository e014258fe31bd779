#pragma once

#include <span>
#include <vector>

#include "core/types/calibration.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// The step in which readings come, as those of a counter or of a coarse converter; 0 where they
/// come in none, or do not vary. Sorts `values`.
double StepOf(std::vector<double>& values);

/// Adds to the checks each used channel whose readings come in steps that are large beside the
/// noise that is left: it is mostly rounding then, and what changes less than a step hides in it.
/// @param samples      of the stretch
/// @param calibration  its noise is known
void SaySteps(std::span<const Sample> samples, Calibration& calibration);

}  // namespace faultlab::core
