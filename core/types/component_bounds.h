#pragma once

// Of any component's value, in its SI unit. Wider than any plant and narrow enough that a model of
// it stays finite. What a rig can switch is narrower still.
namespace faultlab::core {

inline constexpr double kComponentValueMin = 1e-15;
inline constexpr double kComponentValueMax = 1e12;

}  // namespace faultlab::core
