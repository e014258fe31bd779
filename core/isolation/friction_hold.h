#pragma once

#include <span>

#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// True where friction holds a motor near rest: the largest input of the stretch gives the standing
/// motor less than 2.5 times the torque of its Coulomb friction.
/// Break-away and Stribeck friction, which the models do not have, then decide when it turns.
bool HardlyTurns(const RigParameters& rig, std::span<const Observation> stretch);

}  // namespace faultlab::core
