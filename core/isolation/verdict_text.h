#pragma once

#include <string>

#include "core/types/verdict.h"

namespace faultlab::core {

/// "R1 = 100 ohm", "C8 = 1.02 uF", "J < 1e-07 kg m^2".
std::string ValueText(const Candidate& candidate);

/// One sentence for a person about a fault verdict: the candidates of its group with their values.
std::string FaultSentence(const Verdict& verdict);

}  // namespace faultlab::core
