#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

enum class ObstacleKind : std::uint8_t { kSession, kCheck, kBooking, kOutage, kHours };
std::string_view Name(ObstacleKind kind);

/// What keeps one rig, or all of the class, from those who wait for it.
struct Obstacle {
  RigId rig;  ///< kHours: empty
  ObstacleKind kind{};
  Interval during;  ///< of a session or a check: ends then at the latest
  friend bool operator==(const Obstacle&, const Obstacle&) = default;
};

/// First the hours in which the class is closed for this ticket, if they leave no room for it now
/// (without a start: it is closed now; WallTime::max(): nobody knows until when). Then one for each
/// rig that works, ordered by rig: who or what is on it; on a ready rig the first booking or
/// planned outage, before which a waiting session has no room. A ready rig without either is
/// missing: nothing keeps it. A rig that is offline or quarantined is missing too.
std::vector<Obstacle> ObstaclesOf(const LabState& state, const Ticket& ticket, WallTime now);

}  // namespace faultlab::server::lab
