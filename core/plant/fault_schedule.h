#pragma once

#include <span>
#include <vector>

#include "core/plant/plant.h"
#include "core/types/fault.h"
#include "core/types/result.h"

namespace faultlab::core {

/// Refuses a value that is not positive and finite, an at_s < 0, an until_s <= at_s (drift,
/// intermittent); `field` is the member.
Status Validate(const Fault& fault);

/// Plays faults on a plant. A fault acts from the first sample whose time is >= at_s. Touches the
/// plant only when the scheduled value of a component changes, so that live commands stay.
class FaultSchedule {
 public:
  /// `nominal` gives the values that drifts start from and intermittent faults return to.
  FaultSchedule(std::vector<Fault> faults, const PlantParameters& nominal);

  /// Call at the time of each sample, before its input is set. Times never fall.
  void Apply(double t_s, Plant& plant);
  /// Value of this component at t_s under the schedule (the last fault in the list that acts wins).
  double ValueAt(Component component, double t_s) const;

 private:
  std::vector<Fault> faults_;
  PlantParameters nominal_;
  PlantParameters scheduled_;  ///< what was last asked of the plant
};

}  // namespace faultlab::core
