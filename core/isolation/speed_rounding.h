#pragma once

#include <span>

#include "core/filter/observation.h"
#include "core/filter/prediction_model.h"

namespace faultlab::core {

/// Variance ((rad/s)^2) by which the rounding of the speeds of a stretch exceeds that of a healthy
/// motor under the same inputs, 0 if it does not. An encoder's pulse periods are counted by a
/// timer, so a step is w^2 step_s, and a motor that a fault makes faster is read more coarsely. A
/// speed that changes by less than its step keeps its error: the variance is then as many times
/// larger as samples share an error (50 at most), so that together they say no more than they do.
/// @param healthy  the calibrated rig, whose noise includes its own rounding
/// @param step_s   BenchChannel::step_s
double AddedRounding(const PredictionModel& healthy,
                     double step_s,
                     std::span<const Observation> stretch);

}  // namespace faultlab::core
