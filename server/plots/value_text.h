#pragma once

#include <string>
#include <string_view>

#include "core/types/component.h"

namespace faultlab::server {

/// 5600, "ohm" -> "5.6 kΩ"; 4.7e-11, "farad" -> "47 pF"; 1.43e-6, "kg m^2" -> "1.43·10^{−6} kg·m²".
/// Electrical units take SI prefixes, the others a power of ten; `digits` significant digits.
std::string ValueText(double value, std::string_view unit, int digits = 3);

/// "99.6 ± 0.4 Ω": the value with as many digits as its standard error justifies, both in one unit.
/// Without a usable error it is ValueText().
std::string ValueWithErrorText(double value, double sigma, std::string_view unit, int digits = 3);

/// "R_{1}", "C_{8}", "R_{a}", "J", "B".
std::string ComponentLabel(core::Component component);

}  // namespace faultlab::server
