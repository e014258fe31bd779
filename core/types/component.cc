#include "core/types/component.h"

#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr std::array<std::string_view, kComponentCount> kNames = {
    "R1", "R9", "R12", "C8", "Ra", "J", "B"};
constexpr std::array<std::string_view, kComponentCount> kUnits = {
    "ohm", "ohm", "ohm", "farad", "ohm", "kg m^2", "Nm/(rad/s)"};

// Paper Table 2. It prints the third R1 position as "Do156 ohm": line Do1, 56 ohm, as in Tables 3,
// 7, 11, 14.
constexpr std::array<std::array<double, kRelayPositions>, 4> kRelayValues = {{
    {1.0, 10.0, 56.0, 100.0},
    {10e3, 33e3, 56e3, 100e3},
    {10e3, 5.6e3, 3.3e3, 2e3},
    {47e-12, 1e-6, 10e-6, 47e-6},
}};

}  // namespace

std::string_view Name(Component component) {
  return kNames[static_cast<std::size_t>(component)];
}

std::string_view Unit(Component component) {
  return kUnits[static_cast<std::size_t>(component)];
}

std::optional<Component> ParseComponent(std::string_view name) {
  for (Component component : kAllComponents) {
    if (Name(component) == name) return component;
  }
  return std::nullopt;
}

bool IsRelaySwitched(Component component) {
  return Index(component) < 4;
}

const std::array<double, kRelayPositions>& RelayValues(Component component) {
  LAB_CHECK(IsRelaySwitched(component), Name(component));
  return kRelayValues[static_cast<std::size_t>(component)];
}

}  // namespace faultlab::core
