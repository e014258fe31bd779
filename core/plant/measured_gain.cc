#include "core/plant/measured_gain.h"

namespace faultlab::core {

PlantParameters WithMeasuredGain(const PlantParameters& plant, double factor) {
  const Structure& structure = *plant.structure;
  PlantParameters measured = plant;
  for (int i = 0; i < structure.parameter_count() - kMotorParameters; ++i) {
    const double slope = structure.slope(plant.amplifier, i).gain;
    if (slope <= 0.0) continue;
    measured.amplifier[static_cast<std::size_t>(i)] += (factor - 1.0) * plant.gain() / slope;
    break;
  }
  return measured;
}

PlantParameters WithMeasuredLag(const PlantParameters& plant, double factor) {
  const Structure& structure = *plant.structure;
  PlantParameters measured = plant;
  for (int i = kMotorParameters; i < structure.parameter_count(); ++i) {
    if (structure.parameters[static_cast<std::size_t>(i)].kind != PartKind::kCapacitor) continue;
    measured.amplifier[static_cast<std::size_t>(i - kMotorParameters)] *= factor;
  }
  return measured;
}

}  // namespace faultlab::core
