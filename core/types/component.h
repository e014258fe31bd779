#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace faultlab::core {

/// The seven physical parameters whose faults the laboratory knows (paper Eq. (36)).
enum class Component { kR1, kR9, kR12, kC8, kRa, kJ, kB };

inline constexpr int kComponentCount = 7;
inline constexpr std::array<Component, kComponentCount> kAllComponents = {Component::kR1,
                                                                          Component::kR9,
                                                                          Component::kR12,
                                                                          Component::kC8,
                                                                          Component::kRa,
                                                                          Component::kJ,
                                                                          Component::kB};

/// "R1", "R9", "R12", "C8", "Ra", "J", "B".
std::string_view Name(Component component);
/// "ohm", "farad", "kg m^2" or "Nm/(rad/s)": the SI unit in which every value is given.
std::string_view Unit(Component component);
/// Inverse of Name(), exact spelling.
std::optional<Component> ParseComponent(std::string_view name);

/// True for R1, R9, R12, C8, which a relay board switches; the motor's own parameters need a
/// simulator.
bool IsRelaySwitched(Component component);

inline constexpr int kRelayPositions = 4;
/// The values which relays can connect (paper Table 2), in SI units, position 1 = nominal first.
/// Contract: IsRelaySwitched(component).
const std::array<double, kRelayPositions>& RelayValues(Component component);

inline constexpr int Index(Component component) {
  return static_cast<int>(component);
}

}  // namespace faultlab::core
