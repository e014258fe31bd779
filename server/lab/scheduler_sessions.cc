// Rules 1, 4, 5, 6 and 9 of the README: leases, extension, idle, passing on control.
#include <algorithm>

#include "server/lab/notices.h"
#include "server/lab/opening.h"
#include "server/lab/policy_settings.h"
#include "server/lab/scheduler.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab {
namespace {

using core::Done;
using core::Error;

/// A session that goes on into the next booking of its user is alive when that begins.
constexpr Milliseconds kIntoOwnBooking{5'000};
constexpr Milliseconds kExtensionMin{60'000};

Error NoSession() {
  return core::Refuse("no_session");
}

}  // namespace

core::Status Scheduler::ControlActivity(SessionId id, std::uint64_t epoch, WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  if (session->epoch != epoch) {
    return core::Refuse("session_over");
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
  if (session->hard_end - now > kWarnings[0]) {
    return core::Refuse("extend_early", "", {{"from", UtcText(session->hard_end - kWarnings[0])}});
  }
  if (ExtensionLeft(*session) < kExtensionMin) {
    return core::Refuse("extension_limit");
  }
  if (!ExtendIfFree(*session, now)) {
    return core::Refuse("no_extension");
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
    if (!IsFreeForPractice(state_, id, length, now)) continue;  // rule 2
    Session& session = Hold(*FindRig(id), user, now + length, Milliseconds{0}, now);
    session.kind = TicketKind::kPractice;
    session.run_in_progress = true;
    Activate(session, now);
    return session;
  }
  if (among.size() != 1) return core::Refuse("simulators_in_use", "/rig");
  return core::Refuse("rig_in_use", "/rig", {{"rig", among.front()}});
}

void Scheduler::EndPractice(SessionId id, WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->kind != TicketKind::kPractice) return;
  Close(*session, EndReason::kEnded, "the run is over", now);
}

core::Status Scheduler::OfferControl(SessionId id, UserId to, WallTime) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  if (session->kind != TicketKind::kPerson) return NoSession();  // it is for one run
  if (to == session->user) {
    return core::Refuse("control_is_yours", "user");
  }
  session->offered_to = to;
  Touch(*session);
  Notify({to,
          id,
          "control_offered",
          "you are offered the control of " + session->rig,
          session->rig,
          session->user,
          ""});
  return Done{};
}

core::Result<Session> Scheduler::AcceptControl(SessionId id,
                                               UserId user,
                                               WallTime now,
                                               const Courses& courses) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  if (session->offered_to != user || user == UserId{}) {
    return core::Refuse("control_not_offered");
  }
  if (LiveSessionOf(user, session->rig_class) != nullptr) {
    return core::Refuse("other_session_first");
  }
  const Interval rest{now, session->hard_end + policy_.cleaning};
  TRY_DONE(CheckOpen(state_, session->rig_class, courses, rest));
  session->courses = courses;
  Notice notice;
  notice.topic = "handed_over";
  notice.text = "the control went to whom you offered it";
  SwitchController(*session, user, EndReason::kEnded, std::move(notice), now);
  return *session;
}

core::Result<Session> Scheduler::TakeOver(SessionId id,
                                          UserId instructor,
                                          const std::string& reason,
                                          WallTime now) {
  Session* session = FindLive(id);
  if (session == nullptr || session->state != SessionState::kActive) return NoSession();
  if (session->kind != TicketKind::kPerson) return NoSession();  // it is for one run
  if (reason.empty()) return core::Refuse("reason_missing", "reason");
  if (session->user == instructor) return *session;
  if (LiveSessionOf(instructor, session->rig_class) != nullptr) {
    return core::Refuse("other_session_first");
  }
  Notice notice;
  notice.topic = "taken_over";
  notice.text = "your instructor took over: " + reason;
  notice.why = reason;
  SwitchController(*session, instructor, EndReason::kOperator, std::move(notice), now);
  return *session;
}

/// What the policy still allows this session: of its own extensions, and of its user's week.
Milliseconds Scheduler::ExtensionLeft(const Session& session) const {
  const PolicySettings& settings = SettingsOf(session.rig_class);
  const Milliseconds own = settings.extended_max - session.extended;
  if (settings.week_max == Milliseconds{0} || IsElastic(session.rig_class)) return own;
  return std::min(own, settings.week_max - WeekUse(session.user, session.charged_from));
}

bool Scheduler::ExtendIfFree(Session& session, WallTime now) {
  const Milliseconds left = ExtensionLeft(session);
  if (left < kExtensionMin || session.kind != TicketKind::kPerson) return false;
  const WallTime next = RoomUntil(state_.rigs.at(session.rig), session.courses, session.hard_end);
  const WallTime limit = next == WallTime::max() ? next : next - policy_.cleaning;
  if (limit <= session.hard_end + kExtensionMin) return false;
  const Milliseconds step = std::min(SettingsOf(session.rig_class).extend_step, left);
  const WallTime until = std::min(session.hard_end + step, limit);
  const WallTime taken_until = until + policy_.cleaning;
  const WallTime promised = NextCommitment(state_, session.rig, session.hard_end);
  const bool wanted = std::ranges::any_of(state_.tickets, [&](const auto& entry) {
    const Ticket& ticket = entry.second;
    const bool waits = ticket.kind == TicketKind::kPerson &&
                       ticket.state == TicketState::kWaiting &&
                       ticket.rig_class == session.rig_class;
    if (!waits) return false;
    // Who is shut out now may be the next to have it.
    const WallTime open = NextOpen(state_, session.rig_class, ticket.courses, {now, taken_until});
    if (open == WallTime::max()) return false;
    const WallTime shut = NextShut(state_, session.rig_class, ticket.courses, open);
    return open + ticket.min + 2 * policy_.cleaning <= std::min(promised, shut);
  });
  if (wanted) return false;
  session.extended += until - session.hard_end;
  session.hard_end = until;
  session.warning_stage = 0;
  Touch(session);
  Notify(session.user, "extended", "nobody waits: your session goes on", session.id);
  return true;
}

/// What keeps the session from going on: "limit", "outage", "hours", "booking" or "queue".
std::string Scheduler::WhyItEnds(const Session& session) const {
  if (ExtensionLeft(session) < kExtensionMin) return "limit";
  const WallTime room = session.hard_end + kExtensionMin + policy_.cleaning;
  const bool outage =
      std::any_of(state_.outages.begin(), state_.outages.end(), [&](const auto& entry) {
        const Outage& each = entry.second;
        return each.rig == session.rig && each.during.start <= room &&
               each.during.end > session.hard_end;
      });
  if (outage) return "outage";
  const Rig& rig = state_.rigs.at(session.rig);
  if (NextShut(state_, session.rig_class, session.courses, session.hard_end) <= room)
    return "hours";
  return RoomUntil(rig, session.courses, session.hard_end) <= room ? "booking" : "queue";
}

/// The user's next hour on this rig follows on: the session lives until it begins, and becomes it
/// (EndForBooking), without a check between somebody and themselves.
bool Scheduler::GoOnIntoOwnBooking(Session& session) {
  if (session.kind != TicketKind::kPerson || session.state != SessionState::kActive) return false;
  for (const auto& [id, booking] : state_.bookings) {
    const bool own = booking.state == BookingState::kBooked && booking.user == session.user &&
                     booking.rig == session.rig;
    const WallTime start = booking.during.start;
    if (!own || start < session.hard_end || start > session.hard_end + policy_.cleaning) continue;
    session.hard_end = start + kIntoOwnBooking;
    session.warning_stage = 0;
    Touch(session);
    Notify(session.user, "extended", "your next booking follows: your session goes on", session.id);
    return true;
  }
  return false;
}

void Scheduler::TickEnd(Session& session, WallTime now) {
  const Milliseconds left = session.hard_end - now;
  if (left > kWarnings[0]) return;
  if (GoOnIntoOwnBooking(session) || ExtendIfFree(session, now)) return;
  if (left <= Milliseconds{0}) {
    Close(session, EndReason::kExpired, "the time is over", now);
    return;
  }
  if (session.kind != TicketKind::kPerson) return;  // jobs get no warnings
  const int stage = WarningStage(left);
  if (stage <= session.warning_stage) return;
  session.warning_stage = stage;
  Touch(session);
  const std::string reason = WhyItEnds(session);
  Notify({session.user,
          session.id,
          "warning",
          LeftText(left) + ": " + ReasonText(reason, ""),
          session.rig,
          {},
          "",
          reason,
          session.hard_end});
}

void Scheduler::TickIdle(Session& session, WallTime now) {
  const bool busy = session.run_in_progress || session.kind != TicketKind::kPerson;
  if (busy || !SomebodyWaits(session.rig_class, now)) {
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
  const PolicySettings& settings = SettingsOf(session.rig_class);
  if (now - session.last_control < settings.idle) return;
  session.idle_answer_until = now + settings.idle_answer;
  Touch(session);
  Notify(session.user, "idle", "still there? somebody waits for this rig", session.id);
}

void Scheduler::TickSessions(WallTime now) {
  for (auto& [id, session] : state_.sessions) {
    if (session.state == SessionState::kHeld && now >= session.claim_until) {
      const bool booked = session.booking != BookingId{};
      const bool in_week = !IsElastic(session.rig_class);
      if (booked) Charge(session.user, SettingsOf(session.rig_class).no_show_charge, now, in_week);
      Close(session,
            booked ? EndReason::kNoShow : EndReason::kOfferMissed,
            booked ? "not claimed in " + LengthText(SettingsOf(session.rig_class).grace)
                   : "not accepted in time",
            now);
    } else if (session.state == SessionState::kHeld && now >= session.hard_end) {
      Close(session, EndReason::kRigFailed, "the rig is needed by an outage", now);
    }
    if (session.state == SessionState::kActive) TickIdle(session, now);
    if (session.state == SessionState::kActive) TickEnd(session, now);
  }
}

void Scheduler::Tick(WallTime now) {
  TickWindows(now);
  TickSessions(now);
  TickRigs(now);
  TickBookings(now);
  Dispatch(now);
  Estimate(now);
}

}  // namespace faultlab::server::lab
