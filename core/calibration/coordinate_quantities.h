#pragma once

#include <string>

#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// A coordinate of the fit as people know it: "Ra", in ohm.
std::string SymbolOf(const PlantParameters& plant, int coordinate);
const char* UnitOf(const PlantParameters& plant, int coordinate);
double ValueOf(const RigParameters& rig, int coordinate);
/// In that unit. @param sigma  in the coordinate's own
double SigmaOf(const RigParameters& rig, int coordinate, double sigma, double period_s);

}  // namespace faultlab::core
