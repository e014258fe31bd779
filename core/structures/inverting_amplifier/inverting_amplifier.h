#pragma once

#include "core/types/structure.h"

namespace faultlab::core {

/// A power amplifier that inverts twice, a resistor R1 in series, the motor (paper Fig. 2, Eq.
/// (2)):
///   Re1 = R9 || R10,   Re2 = R12 + R14 + R15,   Uout = (Re2 || (R5 + 1/(s C8))) / Re1  Uc
///   gain = Re2/Re1,   lead = R5 C8,   lag = (R5 + Re2) C8
/// um, behind R1, depends on all of R1, R9 or R12, C8 and, through the motor's current, Ra, J and
/// B. Only C8's lag distinguishes R9 from R12: at a small C8 they form one group.
extern const Structure kInvertingAmplifier;

}  // namespace faultlab::core
