#include "core/calibration/coordinate_quantities.h"

#include <algorithm>
#include <array>

namespace faultlab::core {
namespace {

// The second is the structure's own name of the series resistor.
constexpr std::array<const char*, kCoordinateMax> kNames = {
    "k", "", "Ra", "J", "B", "Ke", "Mc", "delta", "La", "lag"};
constexpr std::array<const char*, kCoordinateMax> kUnits = {
    "V/V", "ohm", "ohm", "kg m^2", "Nm/(rad/s)", "V/(rad/s)", "Nm", "s", "henry", "s"};

}  // namespace

std::string SymbolOf(const PlantParameters& plant, int coordinate) {
  return coordinate == static_cast<int>(Coordinate::kSeries)
             ? std::string(plant.structure->parameters[kSeries].symbol)
             : kNames[static_cast<std::size_t>(coordinate)];
}

const char* UnitOf(const PlantParameters& plant, int coordinate) {
  const bool gain = coordinate == static_cast<int>(Coordinate::kGain);
  if (gain && plant.structure->drives_current()) return "A/V";
  return kUnits[static_cast<std::size_t>(coordinate)];
}

double ValueOf(const RigParameters& rig, int coordinate) {
  switch (static_cast<Coordinate>(coordinate)) {
    case Coordinate::kGain:
      return rig.gain() / std::max(1.0, rig.plant.structure->source_ohm);
    case Coordinate::kSeries:
      return rig.plant.series_ohm;
    case Coordinate::kRa:
      return rig.plant.ra_ohm;
    case Coordinate::kJ:
      return rig.plant.j_kg_m2;
    case Coordinate::kB:
      return rig.plant.b_nm_per_rad_s;
    case Coordinate::kKe:
      return rig.plant.ke_v_per_rad_s;
    case Coordinate::kMc:
      return rig.mc_nm;
    case Coordinate::kDelta:
      return rig.delta_s;
    case Coordinate::kLa:
      return rig.plant.la_henry;
    case Coordinate::kLag:
      return rig.lag_factor * rig.plant.response().lag_s;
  }
  return 0.0;
}

double SigmaOf(const RigParameters& rig, int coordinate, double sigma, double period_s) {
  if (coordinate == static_cast<int>(Coordinate::kMc)) return sigma * rig.mc_unit_nm;
  if (coordinate == static_cast<int>(Coordinate::kDelta)) {
    return sigma * kDeltaUnitPeriods * period_s;
  }
  return ValueOf(rig, coordinate) * sigma;
}

}  // namespace faultlab::core
