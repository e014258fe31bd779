#include "server/run/switchable.h"

#include <boost/json.hpp>
#include <cmath>
#include <string>

#include "core/types/component_bounds.h"
#include "server/run/refusals.h"

namespace faultlab::server {
core::Status CheckSwitchable(const hardware::RigDescription& rig,
                             core::Component component,
                             double value) {
  if (!(value >= core::kComponentValueMin && value <= core::kComponentValueMax)) {
    return refusal::NotPositive(component);
  }
  if (!core::IsRelaySwitched(component)) {
    if (rig.motor_faults) return core::Done{};
    return refusal::NotSwitchable(rig.id, component);
  }
  if (rig.any_value) return core::Done{};
  std::string list;
  for (const double known : core::RelayValues(component)) {
    if (std::abs(known - value) <= 1e-9 * known) return core::Done{};
    list.append(list.empty() ? "" : ", ").append(boost::json::serialize(boost::json::value(known)));
  }
  return refusal::NotOfTheRelays(component, list);
}

}  // namespace faultlab::server
