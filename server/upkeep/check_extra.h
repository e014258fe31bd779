#pragma once

#include "hardware/contact_check.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// kCommission: its figures become the rig's band. kClearTrip: it opens the latch of an interlock
/// first. kContacts: each relay position is recognised by its effect, if the rig has no others.
enum class CheckExtra { kCommission, kClearTrip, kContacts };

/// The relay positions of a rig when they were last recognised by their effect.
struct RigContacts {
  WallTime checked;
  hardware::ContactReport report;
};

}  // namespace faultlab::server
