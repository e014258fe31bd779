#pragma once

#include <array>

namespace faultlab::core {

/// {b0, b1 (s), a1 (s)} of the first-order amplifier model, paper Eq. (6).
using ContinuousTheta = std::array<double, 3>;

}  // namespace faultlab::core
