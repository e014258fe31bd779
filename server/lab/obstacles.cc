#include "server/lab/obstacles.h"

#include <array>
#include <optional>

#include "server/lab/opening.h"

namespace faultlab::server::lab {
namespace {

std::optional<Obstacle> OnRig(const LabState& state, const Rig& rig) {
  if (rig.status == RigStatus::kCleaning) {
    return Obstacle{rig.id, ObstacleKind::kCheck, {{}, rig.cleaning_due}};
  }
  for (const auto& [id, session] : state.sessions) {
    if (session.state == SessionState::kClosed || session.rig != rig.id) continue;
    return Obstacle{rig.id, ObstacleKind::kSession, {session.start, session.hard_end}};
  }
  return std::nullopt;
}

std::optional<Obstacle> AheadOf(const LabState& state, const Rig& rig) {
  std::optional<Obstacle> first;
  const auto take = [&](ObstacleKind kind, const Interval& during) {
    if (!first || during.start < first->during.start) first = Obstacle{rig.id, kind, during};
  };
  for (const auto& [id, booking] : state.bookings) {
    if (booking.state != BookingState::kBooked || booking.rig != rig.id) continue;
    take(ObstacleKind::kBooking, booking.during);
  }
  for (const auto& [id, outage] : state.outages) {
    if (outage.rig == rig.id) take(ObstacleKind::kOutage, outage.during);
  }
  return first;
}

}  // namespace

std::string_view Name(ObstacleKind kind) {
  constexpr std::array<std::string_view, 5> kNames = {
      "session", "check", "booking", "outage", "hours"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::vector<Obstacle> ObstaclesOf(const LabState& state, const Ticket& ticket, WallTime now) {
  std::vector<Obstacle> obstacles;
  const Interval soon{now, now + ticket.min};
  const std::vector<Shut> near = ShutTimes(state, ticket.rig_class, ticket.courses, soon);
  if (!near.empty()) {
    WallTime start = near.front().during.start;
    for (const Shut& each : near) start = std::min(start, each.during.start);
    const Interval ahead{std::max(start, now), now + kExpectedWithin};
    const WallTime end = NextOpen(state, ticket.rig_class, ticket.courses, ahead);
    obstacles.push_back({{}, ObstacleKind::kHours, {start <= now ? WallTime{} : start, end}});
  }
  for (const auto& [id, rig] : state.rigs) {
    if (rig.rig_class != ticket.rig_class || rig.status == RigStatus::kOffline ||
        rig.status == RigStatus::kQuarantined) {
      continue;
    }
    std::optional<Obstacle> found = OnRig(state, rig);
    if (!found) found = AheadOf(state, rig);
    if (found) obstacles.push_back(*found);
  }
  return obstacles;
}

}  // namespace faultlab::server::lab
