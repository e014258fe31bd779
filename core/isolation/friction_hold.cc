#include "core/isolation/friction_hold.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

// Break-away friction is at most about twice Coulomb friction, of which Mc is an estimate.
constexpr double kBreakawayShare = 2.5;

}  // namespace

bool HardlyTurns(const RigParameters& rig, std::span<const Observation> stretch) {
  if (stretch.empty()) return false;
  const auto [least, most] = std::ranges::minmax(stretch, {}, &Observation::u);
  const PlantParameters& plant = rig.plant;
  const double drive_v = std::abs(rig.gain()) * std::max(std::abs(least.u), std::abs(most.u));
  const double torque_nm = plant.kt_nm_per_a * drive_v / (plant.ra_ohm + plant.series_ohm);
  return torque_nm < kBreakawayShare * rig.mc_nm;
}

}  // namespace faultlab::core
