#include <set>

#include "server/lab/scheduler.h"

namespace faultlab::server::lab {
namespace {

bool IsLive(const Session& session) {
  return session.state != SessionState::kClosed;
}

std::string CheckSessions(const LabState& state) {
  std::set<RigId> leased;
  std::set<std::pair<UserId, std::string>> holders;
  for (const auto& [id, session] : state.sessions) {
    if (!IsLive(session)) continue;
    const std::string name = "session " + std::to_string(Number(id));
    const auto rig = state.rigs.find(session.rig);
    if (rig == state.rigs.end()) return name + " has no rig";
    if (!leased.insert(session.rig).second) return "two sessions on " + session.rig;
    if (rig->second.status != RigStatus::kLeased) return name + " on a rig that is not leased";
    const bool active = session.state == SessionState::kActive;
    if (active && session.epoch != rig->second.epoch) return name + " has a stale epoch";
    if (!active && session.epoch != 0) return name + " is held but has an epoch";
    const bool person = session.kind == TicketKind::kPerson;
    if (person && !holders.insert({session.user, session.rig_class}).second) {
      return "user " + std::to_string(Number(session.user)) + " has two sessions in a class";
    }
  }
  for (const auto& [id, rig] : state.rigs) {
    if (rig.status == RigStatus::kLeased && !leased.contains(id)) return id + " leased to nobody";
  }
  return {};
}

std::string CheckTickets(const LabState& state) {
  std::set<std::pair<UserId, std::string>> waiting;
  for (const auto& [id, ticket] : state.tickets) {
    const std::string name = "ticket " + std::to_string(Number(id));
    const bool live =
        ticket.state == TicketState::kWaiting || ticket.state == TicketState::kOffered;
    if (live && ticket.kind == TicketKind::kPerson &&
        !waiting.insert({ticket.user, ticket.rig_class}).second) {
      return name + " is the second of its user";
    }
    if (ticket.state != TicketState::kOffered) continue;
    const auto session = state.sessions.find(ticket.offered);
    if (session == state.sessions.end() || session->second.state != SessionState::kHeld ||
        session->second.ticket != id) {
      return name + " is offered nothing";
    }
  }
  return {};
}

std::string CheckBookings(const LabState& state) {
  for (const auto& [id, booking] : state.bookings) {
    const std::string name = "booking " + std::to_string(Number(id));
    const bool bound =
        booking.state == BookingState::kHeld || booking.state == BookingState::kClaimed;
    if (bound) {
      const auto session = state.sessions.find(booking.session);
      if (session == state.sessions.end() || !IsLive(session->second) ||
          session->second.booking != id) {
        return name + " is bound to no session";
      }
    }
    if (booking.state == BookingState::kWaiting && !booking.rig.empty()) {
      return name + " waits and has a rig";
    }
    if (booking.state != BookingState::kBooked || booking.rig.empty()) continue;
    for (const auto& [other_id, other] : state.bookings) {
      if (other_id <= id || other.state != BookingState::kBooked) continue;
      if (other.rig == booking.rig && other.during.Overlaps(booking.during)) {
        return name + " overlaps booking " + std::to_string(Number(other_id)) + " on " +
               booking.rig;
      }
    }
  }
  return {};
}

}  // namespace

std::string FindBrokenInvariant(const LabState& state) {
  for (const auto& check : {CheckSessions, CheckTickets, CheckBookings}) {
    std::string broken = check(state);
    if (!broken.empty()) return broken;
  }
  return {};
}

}  // namespace faultlab::server::lab
