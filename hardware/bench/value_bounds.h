#pragma once

namespace faultlab::hardware {

/// Wider than any part that is sold; in SI units.
inline constexpr double kValueMin = 1e-15;
inline constexpr double kValueMax = 1e12;
/// Faster than any motor. A range of the speed that ends here has no end.
inline constexpr double kRpmMax = 1e6;

}  // namespace faultlab::hardware
