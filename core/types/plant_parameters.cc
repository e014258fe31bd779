#include "core/types/plant_parameters.h"

#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr std::array<double PlantParameters::*, kMotorParameters> kMotor = {
    &PlantParameters::series_ohm,
    &PlantParameters::ra_ohm,
    &PlantParameters::la_henry,
    &PlantParameters::ke_v_per_rad_s,
    &PlantParameters::kt_nm_per_a,
    &PlantParameters::j_kg_m2,
    &PlantParameters::b_nm_per_rad_s};

}  // namespace

double PlantParameters::Get(int parameter) const {
  LAB_CHECK(structure != nullptr && parameter >= 0 && parameter < structure->parameter_count(),
            parameter);
  if (parameter < kMotorParameters) return this->*kMotor[static_cast<std::size_t>(parameter)];
  return amplifier[static_cast<std::size_t>(parameter - kMotorParameters)];
}

void PlantParameters::Set(int parameter, double value) {
  LAB_CHECK(structure != nullptr && parameter >= 0 && parameter < structure->parameter_count(),
            parameter);
  if (parameter < kMotorParameters) {
    this->*kMotor[static_cast<std::size_t>(parameter)] = value;
  } else {
    amplifier[static_cast<std::size_t>(parameter - kMotorParameters)] = value;
  }
}

void PlantParameters::Set(Component component, double value) {
  LAB_CHECK(value > 0.0, Name(component), value);
  const ComponentInfo& info = component.info();
  Set(info.parameter, value);
  if (info.coupled >= 0) Set(info.coupled, value * info.coupled_ratio);
}

}  // namespace faultlab::core
