#include "server/run/switchable.h"

#include <boost/json.hpp>
#include <cmath>
#include <string>

#include "core/types/component_bounds.h"

namespace faultlab::server {
core::Status CheckSwitchable(const hardware::RigDescription& rig,
                             core::Component component,
                             double value) {
  if (!component.exists()) {
    return core::Refuse("member_missing", "component", {{"member", "component"}});
  }
  if (!(value >= core::kComponentValueMin && value <= core::kComponentValueMax)) {
    return core::Refuse("value_not_positive", "value", {{"component", core::Name(component)}});
  }
  if (!core::IsSwitched(component)) {
    if (rig.motor_faults) return core::Done{};
    return core::Refuse("component_not_switchable",
                        "component",
                        {{"rig", rig.id}, {"component", core::Name(component)}});
  }
  if (rig.any_value) return core::Done{};
  std::string list;
  for (const core::SwitchPosition& position : component.info().positions) {
    const double known = position.value;
    if (std::abs(known - value) <= 1e-9 * known) return core::Done{};
    list.append(list.empty() ? "" : ", ").append(boost::json::serialize(boost::json::value(known)));
  }
  return core::Refuse(
      "value_not_of_the_relays",
      "value",
      {{"component", core::Name(component)}, {"values", list}, {"unit", core::Unit(component)}});
}

}  // namespace faultlab::server
