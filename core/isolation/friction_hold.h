#pragma once

#include <span>

#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"
#include "core/isolation/hypothesis.h"

namespace faultlab::core {

/// True where friction holds a motor near rest: the largest input of the stretch gives the standing
/// motor less than 2.5 times the torque of its Coulomb friction.
/// Break-away and Stribeck friction, which the models do not have, then decide when it turns.
bool HardlyTurns(const RigParameters& rig, std::span<const Observation> stretch);

/// True where the component of `fit` brings the motor there: it leaves no more than noise, or, as
/// friction near rest is more than Coulomb's, up to six times the noise and a twentieth of what the
/// nominal rig leaves.
bool BringsToRest(const FitContext& context, const HypothesisFit& fit);

/// True where `other` leaves hardly more than `best`, which holds the motor near rest: the friction
/// there may make that difference. `was_alike`: when the motor came to rest; it moves too little
/// since then to tell them apart.
bool IsAlikeNearRest(const HypothesisFit& best, const HypothesisFit& other, bool was_alike);

}  // namespace faultlab::core
