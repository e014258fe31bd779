#pragma once

#include <array>
#include <cstddef>

#include "core/types/structure.h"

namespace faultlab::core {

/// The parameters of a structure: those of the motor, in the order of MotorParameter, and then its
/// own.
/// @param series  the resistor between the output terminal and the motor
template <std::size_t N>
constexpr std::array<ParameterInfo, kMotorParameters + N> WithMotor(
    const ParameterInfo& series, const std::array<ParameterInfo, N>& own) {
  std::array<ParameterInfo, kMotorParameters + N> all = {
      {series,
       {"Ra", "ohm", "armature resistance", PartKind::kResistor},
       {"La", "henry", "armature inductance"},
       {"Ke", "V/(rad/s)", "voltage constant"},
       {"KT", "Nm/A", "torque constant"},
       {"J", "kg m^2", "moment of inertia"},
       {"B", "Nm/(rad/s)", "viscous friction"}}};
  for (std::size_t i = 0; i < N; ++i) all[kMotorParameters + i] = own[i];
  return all;
}

}  // namespace faultlab::core
