#pragma once

#include "core/types/structure.h"

namespace faultlab::core {

/// A driver whose gain is known (an H-bridge, a servo amplifier in voltage mode) and the motor,
/// with or without a shunt Rs in series:
///   Uout = k Uc,   ia = k (J s + B) / (J (Ra+Rs) s + B (Ra+Rs) + Ke KT) Uc
/// Without a shunt um is the driver's own output and gives only k; the other information is in ia
/// and n. ia distinguishes k, Ra, J and B; n alone does not separate k from Ke, nor J from Ra.
extern const Structure kMotorDriver;

/// The same, of which the speed alone is measured:
///   n = k KT / (J (Ra+Rs) s + B (Ra+Rs) + Ke KT) Uc, in rpm behind the gear
/// The record tells a gain, a time constant and the friction; values of parts carry the tolerances
/// of the data sheet.
extern const Structure kMotorBySpeed;

/// An amplifier whose feedback is of the current (current mode):
///   ia = k Uc,   um = k (Ra + Ke KT / (J s + B)) Uc
/// The motor's voltage has no say in its speed, so that the gain, its own circuit and a series
/// resistor cannot be told by faults of theirs: of the amplifier k alone is a parameter.
extern const Structure kCurrentDriver;

}  // namespace faultlab::core
