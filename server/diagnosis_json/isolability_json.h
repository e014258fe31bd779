#pragma once

#include <boost/json/object.hpp>
#include <string>

#include "core/isolability/isolability.h"

namespace faultlab::server {

/// {"components":["R1",..],"fisher":[[..]],"overlap":[[..]],"smallest":[{"component","nominal",
/// "below","above","relative_sigma"}],"faults":[{"component","value","unit","kl_nominal","visible",
/// "rivals":[{"component","kl","value"}],"group":[..]}],"ambiguous":[["R9","R12"]],"kl_visible",
/// "kl_separable"}; distances in nats.
boost::json::object ToJson(const core::Isolability& isolability);

/// The same for people: which faults are visible, down to which size, and which can be confused.
std::string ToText(const core::Isolability& isolability);

}  // namespace faultlab::server
