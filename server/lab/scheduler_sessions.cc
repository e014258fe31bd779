// Rules 1, 4, 5, 6 and 9 of the README: leases, extension, idle, passing on control.
#include <algorithm>
#include <array>

#include "server/lab/scheduler.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

constexpr Milliseconds kExtensionMin{60'000};

struct Warning {
  Milliseconds before;
  const char* text;
};
constexpr std::array<Warning, 3> kWarnings = {{{Milliseconds{300'000}, "5 minutes left"},
                                               {Milliseconds{60'000}, "1 minute left"},
                                               {Milliseconds{30'000}, "30 seconds left"}}};

Error NoSession() {
  return {ErrorCode::kNotFound, "there is no such session, or it has ended", ""};
}

}  // namespace

core::Status Scheduler::ControlActivity(SessionId id, std::uint64_t epoch, WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  if (session->epoch != epoch) {
    return Error{ErrorCode::kStale, "your session on this rig has ended", ""};
  }
  session->last_control = now;
  session->idle_answer_until.reset();
  Touch(*session);
  return Done{};
}

core::Status Scheduler::StillThere(SessionId id, WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  session->last_control = now;
  session->idle_answer_until.reset();
  Touch(*session);
  return Done{};
}

core::Status Scheduler::RunStarted(SessionId id, WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  session->run_in_progress = true;
  session->last_control = now;
  session->idle_answer_until.reset();
  Touch(*session);
  return Done{};
}

core::Status Scheduler::RunEnded(SessionId id, WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  session->run_in_progress = false;
  session->last_control = now;
  Touch(*session);
  return Done{};
}

core::Result<Session> Scheduler::Extend(SessionId id, WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  if (!ExtendIfFree(*session, now)) {
    return Error{ErrorCode::kBusy, "no extension: somebody waits or a booking begins", ""};
  }
  return *session;
}

core::Status Scheduler::EndSession(SessionId id,
                                   EndReason reason,
                                   const std::string& text,
                                   WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr) return NoSession();
  Close(*session, reason, text, now);
  Tick(now);
  return Done{};
}

core::Result<Session> Scheduler::Practice(UserId user,
                                          const std::vector<RigId>& among,
                                          Milliseconds length,
                                          WallTime now) {
  for (const RigId& id : among) {
    Rig* rig = FindRig(id);
    if (rig == nullptr || !rig->elastic || rig->status != RigStatus::kReady) continue;
    Session& session = Hold(*rig, user, now + length, Milliseconds{0}, now);
    session.kind = TicketKind::kPractice;
    session.run_in_progress = true;
    Activate(session, now);
    return session;
  }
  const bool one = among.size() == 1;
  return Error{ErrorCode::kBusy,
               one ? "rig '" + among.front() + "' is in use; try again soon"
                   : "every simulated rig is in use; try again soon",
               "/rig",
               one ? "rig_in_use" : "simulators_in_use",
               {{"rig", one ? among.front() : ""}}};
}

void Scheduler::EndPractice(SessionId id, WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->kind != TicketKind::kPractice) return;
  Close(*session, EndReason::kEnded, "the run is over", now);
}

core::Status Scheduler::OfferControl(SessionId id, UserId to, WallTime) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  if (session->kind == TicketKind::kPractice) return NoSession();
  if (to == session->user) {
    return Error{ErrorCode::kInvalid, "you have the control already", "user"};
  }
  session->offered_to = to;
  Touch(*session);
  Notify(to, "control_offered", "you are offered the control of " + session->rig, id);
  return Done{};
}

core::Result<Session> Scheduler::AcceptControl(SessionId id, UserId user, WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  if (session->offered_to != user || user == UserId{}) {
    return Error{ErrorCode::kForbidden, "the control was not offered to you", ""};
  }
  if (LiveSessionOf(user, session->rig_class) != nullptr) {
    return Error{ErrorCode::kConflict, "end your other session in this class first", ""};
  }
  SwitchController(*session, user, now);
  return *session;
}

core::Result<Session> Scheduler::TakeOver(SessionId id,
                                          UserId instructor,
                                          const std::string& reason,
                                          WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  if (session->kind == TicketKind::kPractice) return NoSession();
  if (reason.empty()) return Error{ErrorCode::kInvalid, "say why: it is logged", "reason"};
  if (session->user == instructor) return *session;
  if (LiveSessionOf(instructor, session->rig_class) != nullptr) {
    return Error{ErrorCode::kConflict, "end your other session in this class first", ""};
  }
  Notify(session->user, "taken_over", "your instructor took over: " + reason, id);
  SwitchController(*session, instructor, now);
  return *session;
}

bool Scheduler::ExtendIfFree(Session& session, WallTime now) {
  if (session.kind != TicketKind::kPerson) return false;
  const WallTime next = NextCommitment(state_, session.rig, session.hard_end);
  if (next == WallTime::max() || next - policy_.cleaning > session.hard_end + kExtensionMin) {
    const WallTime limit = next == WallTime::max() ? next : next - policy_.cleaning;
    const WallTime until = std::min(session.hard_end + policy_.extend_step, limit);
    const Milliseconds room = next == WallTime::max() ? Milliseconds::max() : limit - now;
    const bool wanted =
        std::any_of(state_.tickets.begin(), state_.tickets.end(), [&](const auto& entry) {
          const Ticket& ticket = entry.second;
          return ticket.state == TicketState::kWaiting && ticket.rig_class == session.rig_class &&
                 ticket.min + policy_.cleaning <= room;
        });
    if (wanted) return false;
    session.hard_end = until;
    session.warning_stage = 0;
    Touch(session);
    Notify(session.user, "extended", "nobody waits: your session goes on", session.id);
    return true;
  }
  return false;
}

void Scheduler::TickEnd(Session& session, WallTime now) {
  const Milliseconds left = session.hard_end - now;
  if (left > kWarnings[0].before) return;
  if (ExtendIfFree(session, now)) return;
  if (left <= Milliseconds{0}) {
    Close(session, EndReason::kExpired, "the time is over", now);
    return;
  }
  if (session.kind != TicketKind::kPerson) return;  // jobs get no warnings
  int stage = 0;
  while (stage < 3 && left <= kWarnings[static_cast<std::size_t>(stage)].before) ++stage;
  if (stage <= session.warning_stage) return;
  session.warning_stage = stage;
  Touch(session);
  const bool queue = SomebodyWaits(session.rig_class);
  Notify(session.user,
         "warning",
         std::string(kWarnings[static_cast<std::size_t>(stage - 1)].text) +
             (queue ? ": somebody waits for this rig" : ": a booking or an outage begins"),
         session.id);
}

void Scheduler::TickIdle(Session& session, WallTime now) {
  const bool busy = session.run_in_progress || session.kind != TicketKind::kPerson;
  if (busy || !SomebodyWaits(session.rig_class)) {
    if (session.idle_answer_until) {
      session.idle_answer_until.reset();
      Touch(session);
    }
    return;
  }
  if (session.idle_answer_until) {
    if (now >= *session.idle_answer_until) {
      Close(session, EndReason::kIdle, "no sign of life, and somebody waits", now);
    }
    return;
  }
  if (now - session.last_control < policy_.idle) return;
  session.idle_answer_until = now + policy_.idle_answer;
  Touch(session);
  Notify(session.user, "idle", "still there? somebody waits for this rig", session.id);
}

void Scheduler::TickSessions(WallTime now) {
  for (auto& [id, session] : state_.sessions) {
    if (session.state == SessionState::kHeld && now >= session.claim_until) {
      const bool booked = session.booking != BookingId{};
      if (booked) Charge(session.user, policy_.no_show_charge, now);
      Close(session,
            booked ? EndReason::kNoShow : EndReason::kOfferMissed,
            booked ? "not claimed in 3 minutes" : "not accepted in time",
            now);
    } else if (session.state == SessionState::kHeld && now >= session.hard_end) {
      Close(session, EndReason::kRigFailed, "the rig is needed by an outage", now);
    }
    if (session.state == SessionState::kActive) TickIdle(session, now);
    if (session.state == SessionState::kActive) TickEnd(session, now);
  }
}

void Scheduler::Tick(WallTime now) {
  TickSessions(now);
  TickRigs(now);
  TickBookings(now);
  Dispatch(now);
  Estimate(now);
}

}  // namespace faultlab::server::lab
