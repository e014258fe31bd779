#pragma once

#include <span>
#include <vector>

#include "core/plant/plant.h"
#include "core/types/fault.h"
#include "core/types/result.h"

namespace faultlab::core {

/// Refuses a value that is not positive and finite, an at_s < 0, and an until_s <= at_s (drift,
/// intermittent); `field` names the member.
Status Validate(const Fault& fault);

/// Applies faults to a plant. A fault acts from the first sample whose time is >= at_s. The plant
/// is changed only when the scheduled value of a component changes, so that live commands keep
/// their effect.
class FaultSchedule {
 public:
  /// `nominal` has the values from which drifts start and to which intermittent faults return.
  FaultSchedule(std::vector<Fault> faults, const PlantParameters& nominal);

  /// Call at the time of each sample, before its input is set. Times must not decrease.
  void Apply(double t_s, Plant& plant);
  /// Value of this component at t_s under the schedule (the last fault in the list that acts wins).
  double ValueAt(Component component, double t_s) const;

 private:
  std::vector<Fault> faults_;
  PlantParameters nominal_;
  PlantParameters scheduled_;  ///< the values last set in the plant
};

}  // namespace faultlab::core
