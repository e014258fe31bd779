#pragma once

#include "core/bench/bench.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// The directions of the detection bank: gain, series resistor, capacitor or Ke, Ra, J, B, Ra and J
/// far off, Mc. A component that the bench does not have gets no response and never decides.
///
/// A rig with the finite change whose response is the direction: about the smallest fault of
/// interest of each component. Near its nominal value a capacitor has no effect, so its direction
/// is the secant to the smallest visible value. Large changes of Ra and J have other responses than
/// small ones, so they have secants of their own.
/// @param direction  from 0 to ModelError::kDirections - 1
RigParameters ChangedIn(const Bench& bench, const RigParameters& reference, int direction);

/// In which direction a change of the coordinate acts most; -1: in none.
int DirectionOf(const Bench& bench, Coordinate coordinate);

}  // namespace faultlab::core
