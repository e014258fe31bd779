#include "server/run/switchable.h"

#include <boost/json.hpp>
#include <cmath>
#include <string>

namespace faultlab::server {
namespace {

core::Error Refusal(std::string field, std::string message) {
  return {core::ErrorCode::kInvalid, std::move(message), std::move(field)};
}

}  // namespace

core::Status CheckSwitchable(const hardware::RigDescription& rig,
                             core::Component component,
                             double value) {
  const std::string name(core::Name(component));
  if (!(std::isfinite(value) && value > 0.0)) {
    return Refusal("value", name + " must be above 0, in the SI unit.");
  }
  if (!core::IsRelaySwitched(component)) {
    if (rig.motor_faults) return core::Done{};
    return Refusal("component", "Rig '" + rig.id + "' cannot change " + name + ".");
  }
  if (rig.any_value) return core::Done{};
  std::string list;
  for (const double known : core::RelayValues(component)) {
    if (std::abs(known - value) <= 1e-9 * known) return core::Done{};
    list.append(list.empty() ? "" : ", ").append(boost::json::serialize(boost::json::value(known)));
  }
  return Refusal("value", "The relay board of " + name + " has " + list + ".");
}

}  // namespace faultlab::server
