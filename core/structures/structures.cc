#include "core/structures/structures.h"

#include <array>

#include "core/structures/inverting_amplifier/inverting_amplifier.h"
#include "core/structures/motor_driver/motor_driver.h"

namespace faultlab::core {

std::span<const Structure* const> Structures() {
  static constexpr std::array<const Structure*, 4> kStructures = {
      &kInvertingAmplifier, &kMotorDriver, &kMotorBySpeed, &kCurrentDriver};
  return kStructures;
}

const Structure* FindStructure(std::string_view name) {
  for (const Structure* structure : Structures()) {
    if (structure->name == name) return structure;
  }
  return nullptr;
}

}  // namespace faultlab::core
