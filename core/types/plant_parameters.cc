#include "core/types/plant_parameters.h"

#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr std::array<double PlantParameters::*, kComponentCount> kMembers = {
    &PlantParameters::r1_ohm,
    &PlantParameters::r9_ohm,
    &PlantParameters::r12_ohm,
    &PlantParameters::c8_farad,
    &PlantParameters::ra_ohm,
    &PlantParameters::j_kg_m2,
    &PlantParameters::b_nm_per_rad_s};

}  // namespace

double PlantParameters::Get(Component component) const {
  return this->*kMembers[static_cast<std::size_t>(component)];
}

void PlantParameters::Set(Component component, double value) {
  LAB_CHECK(value > 0.0, Name(component), value);
  this->*kMembers[static_cast<std::size_t>(component)] = value;
}

}  // namespace faultlab::core
