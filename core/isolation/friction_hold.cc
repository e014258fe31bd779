#include "core/isolation/friction_hold.h"

#include <algorithm>
#include <cmath>

#include "core/isolation/lack_of_fit.h"

namespace faultlab::core {
namespace {

// Break-away friction is at most about twice Coulomb friction, of which Mc is an estimate.
constexpr double kBreakawayShare = 2.5;

// Of BringsToRest: in noise, and less than what the nominal rig leaves.
constexpr double kScoreMax = 6.0;
constexpr double kStandsOut = 20.0;
// Of IsAlikeNearRest: ratios of all that is left, of the part of it that is no noise, and of all
// that is left once the motor is at rest.
constexpr double kAlike = 1.2;
constexpr double kAlikeUnexplained = 1.6;
constexpr double kAlikeOnceAtRest = 2.0;

}  // namespace

bool HardlyTurns(const RigParameters& rig, std::span<const Observation> stretch) {
  if (stretch.empty()) return false;
  const auto [least, most] = std::ranges::minmax(stretch, {}, &Observation::u);
  const PlantParameters& plant = rig.plant;
  const double drive_v = std::abs(rig.gain()) * std::max(std::abs(least.u), std::abs(most.u));
  const double torque_nm = plant.kt_nm_per_a * drive_v / (plant.ra_ohm + plant.series_ohm);
  return torque_nm < kBreakawayShare * rig.mc_nm;
}

bool BringsToRest(const FitContext& context, const HypothesisFit& fit) {
  const RigParameters rig = WithComponent(context.RigAt(fit.nuisance), fit.component, fit.value);
  if (fit.chi2 >= kScoreMax * fit.count || !HardlyTurns(rig, context.stretch)) return false;
  return FitsNoise(fit.chi2, fit.count) || kStandsOut * fit.chi2 < FitNullHypothesis(context).chi2;
}

bool IsAlikeNearRest(const HypothesisFit& best, const HypothesisFit& other, bool was_alike) {
  const double noise = best.count;
  const double left = std::max(best.chi2, noise);
  if (was_alike) return other.chi2 < kAlikeOnceAtRest * left;
  return other.chi2 < std::max(kAlike * left, noise + kAlikeUnexplained * (left - noise));
}

}  // namespace faultlab::core
