#include "core/detection/directions.h"

#include <algorithm>

namespace faultlab::core {
namespace {

/// The component of a bench that acts only when it is large: the capacitor of its amplifier.
const ComponentInfo* CapacitorOf(const Bench& bench) {
  const auto found = std::find_if(bench.parts.begin(), bench.parts.end(), [](const auto& part) {
    return part.kind == PartKind::kCapacitor;
  });
  return found != bench.parts.end() ? &*found : nullptr;
}

}  // namespace

RigParameters ChangedIn(const Bench& bench, const RigParameters& reference, int direction) {
  RigParameters changed = reference;
  PlantParameters& plant = changed.plant;
  const ComponentInfo* capacitor = CapacitorOf(bench);
  switch (direction) {
    case 0:
      changed.gain_factor *= 0.98;
      break;
    case 1:
      plant.series_ohm *= 2.0;
      break;
    case 2:
      if (capacitor != nullptr) {
        plant.Set(capacitor->parameter, plant.Get(capacitor->parameter) + capacitor->least_visible);
      } else {
        plant.ke_v_per_rad_s *= 0.95;
      }
      break;
    case 3:
      plant.ra_ohm *= 0.9;
      break;
    case 4:
      plant.j_kg_m2 *= 1.1;
      break;
    case 5:
      plant.b_nm_per_rad_s *= 3.0;
      break;
    case 6:
      plant.ra_ohm *= 0.15;
      break;
    case 7:
      plant.j_kg_m2 *= 10.0;
      break;
    default:
      changed.mc_nm += changed.mc_unit_nm;
      break;
  }
  return changed;
}

int DirectionOf(const Bench& bench, Coordinate coordinate) {
  switch (coordinate) {
    case Coordinate::kGain:
      return 0;
    case Coordinate::kSeries:
      return 1;
    case Coordinate::kKe:
      return CapacitorOf(bench) == nullptr ? 2 : -1;
    case Coordinate::kRa:
      return 3;
    case Coordinate::kJ:
      return 4;
    case Coordinate::kB:
      return 5;
    default:
      return -1;
  }
}

}  // namespace faultlab::core
