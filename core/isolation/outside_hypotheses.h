#pragma once

#include <optional>

#include "core/isolation/fit_context.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// The hypothesis that what has changed since the stretch began is no component: one sensor, or the
/// motor's dry friction. One of the two is set.
struct OutsideFit {
  std::optional<SensorChange> sensor;
  std::optional<FrictionChange> friction;
  double cost = 0.0;  ///< as HypothesisFit::cost
  /// Cost with Laplace's width of the value, as components have it: less 2 log(sd), where their
  /// prior of the value has a standard deviation of kValueLogSd.
  double evidence = 0.0;
  double chi2 = 0.0;
  int count = 0;
};

/// The likeliest of them: the zero or the gain of um, ia or n, or the dry friction, fitted together
/// with the calibration's coordinates, as the components are; or a sensor that is lost, so that its
/// readings are constant, or noise. All are tried with the coordinates held first (the innovations
/// are linear in a zero, in a gain and, while the motor turns, in the friction, so that is exact);
/// the three best are fitted, and lost ones. None where the stretch has readings of one channel
/// only: there a gain of the sensor looks like one of the amplifier. None either when no change
/// with the coordinates held comes below `worth_cost`. Cost: eight filters side by side, three
/// more, and at most three MAP fits.
/// @param turns  else only what is lost
std::optional<OutsideFit> BestOutside(const FitContext& context, double worth_cost, bool turns);

}  // namespace faultlab::core
