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
  if (!component.exists()) {
    return core::Error{core::ErrorCode::kInvalid,
                       "Say which component.",
                       "component",
                       "member_missing",
                       {{"member", "component"}}};
  }
  if (!(value >= core::kComponentValueMin && value <= core::kComponentValueMax)) {
    return refusal::NotPositive(component);
  }
  if (!core::IsSwitched(component)) {
    if (rig.motor_faults) return core::Done{};
    return refusal::NotSwitchable(rig.id, component);
  }
  if (rig.any_value) return core::Done{};
  std::string list;
  for (const core::SwitchPosition& position : component.info().positions) {
    const double known = position.value;
    if (std::abs(known - value) <= 1e-9 * known) return core::Done{};
    list.append(list.empty() ? "" : ", ").append(boost::json::serialize(boost::json::value(known)));
  }
  return refusal::NotOfTheRelays(component, list);
}

}  // namespace faultlab::server
