#pragma once

#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// `plant` with its gain multiplied by `factor`. It is unknown which part is off, so the first
/// amplifier parameter that increases the gain is changed (R12 of the paper's bench, the gain of a
/// driver).
PlantParameters WithMeasuredGain(const PlantParameters& plant, double factor);

/// The plant with another lag of its amplifier, as if its capacitor were off: lag_s times `factor`,
/// the direct share as it is.
PlantParameters WithMeasuredLag(const PlantParameters& plant, double factor);

}  // namespace faultlab::core
