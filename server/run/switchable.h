#pragma once

#include "core/types/component.h"
#include "core/types/result.h"
#include "hardware/rig.h"

namespace faultlab::server {

/// Whether the rig can give a component this value, according to the rig's description. Error.field
/// is "component" or "value".
core::Status CheckSwitchable(const hardware::RigDescription& rig,
                             core::Component component,
                             double value);

}  // namespace faultlab::server
