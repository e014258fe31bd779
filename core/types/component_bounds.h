#pragma once

// Bounds of any component's value, in its SI unit. They are wider than any plant, and narrow enough
// that its model stays finite. The values that a rig can switch have narrower bounds.
namespace faultlab::core {

inline constexpr double kComponentValueMin = 1e-15;
inline constexpr double kComponentValueMax = 1e12;

}  // namespace faultlab::core
