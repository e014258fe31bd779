#pragma once

#include <string>

#include "core/types/calibration.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// "R1 = 100 ohm", "C8 = 1.02 uF", "J < 1e-07 kg m^2".
std::string ValueText(const Candidate& candidate);

/// One sentence about a fault verdict, for a person: the candidates of its group with their values.
std::string FaultSentence(const Verdict& verdict);

/// What a sentence about a drift ends with: ", and moves by +400 ohm a second"; of one that has
/// ended, whose rate is 0: " after it has moved".
std::string RateText(Component component, double rate);

/// "ia reads 0.03 A too much: its sensor, no component"
std::string SensorSentence(const SensorChange& change);

/// "dry friction takes 0.99 mNm, 0.33 before: bearings or brushes, no component"
std::string FrictionSentence(const FrictionChange& change);

/// The channels that a rig was calibrated with: "um", "um and ia", "um, ia and n".
std::string ChannelsOf(const Calibration& calibration);

}  // namespace faultlab::core
