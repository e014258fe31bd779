#include "server/lab/scheduler.h"

#include <algorithm>

#include "core/types/check.h"
#include "server/lab/fair_order.h"
#include "server/lab/opening.h"
#include "server/lab/policy_settings.h"

namespace faultlab::server::lab {
namespace {

template <typename Map, typename Ids, typename Ended, typename Out>
void Collect(Map& map, Ids& ids, Out& out, const Ended& ended) {
  for (const auto& id : ids) {
    const auto found = map.find(id);
    if (found == map.end()) continue;
    out.push_back(found->second);
    if (ended(found->second)) map.erase(found);
  }
  ids.clear();
}

bool Ended(const Ticket& ticket) {
  return ticket.state != TicketState::kWaiting && ticket.state != TicketState::kOffered;
}
bool Ended(const Booking& booking) {
  return !IsLive(booking);
}
bool Ended(const Session& session) {
  return session.state == SessionState::kClosed;
}

}  // namespace

bool Changes::empty() const {
  return rigs.empty() && outages.empty() && ended_outages.empty() && tickets.empty() &&
         bookings.empty() && sessions.empty() && usage.empty() && windows.empty() &&
         ended_windows.empty() && settings.empty();
}

Scheduler::Scheduler(Policy policy, LabState state) : policy_(policy), state_(std::move(state)) {
  const auto changed = state_.settings.find("");
  if (changed != state_.settings.end()) static_cast<PolicySettings&>(policy_) = changed->second;
}

bool Scheduler::IsElastic(const std::string& rig_class) const {
  return std::any_of(state_.rigs.begin(), state_.rigs.end(), [&](const auto& entry) {
    return entry.second.rig_class == rig_class && entry.second.elastic;
  });
}

Milliseconds Scheduler::WeekUse(UserId user, WallTime at) const {
  const std::int64_t week = WeekOf(at);
  Milliseconds use{};
  const auto past = state_.usage.find(user);
  if (past != state_.usage.end() && past->second.week == week) use += past->second.this_week;
  for (const auto& [id, session] : state_.sessions) {
    const bool counts = !Ended(session) && session.kind == TicketKind::kPerson &&
                        session.user == user && WeekOf(session.charged_from) == week;
    if (counts && !IsElastic(session.rig_class)) use += session.hard_end - session.charged_from;
  }
  for (const auto& [id, booking] : state_.bookings) {
    const bool counts = booking.state == BookingState::kBooked && booking.user == user &&
                        WeekOf(booking.during.start) == week;
    if (counts && !IsElastic(booking.rig_class)) use += booking.during.length();
  }
  return use;
}

Rig* Scheduler::FindRig(const RigId& id) {
  const auto found = state_.rigs.find(id);
  return found == state_.rigs.end() ? nullptr : &found->second;
}

Session* Scheduler::FindLive(SessionId id) {
  const auto found = state_.sessions.find(id);
  if (found == state_.sessions.end() || Ended(found->second)) return nullptr;
  return &found->second;
}

Session* Scheduler::LiveSessionOn(const RigId& rig) {
  for (auto& [id, session] : state_.sessions) {
    if (!Ended(session) && session.rig == rig) return &session;
  }
  return nullptr;
}

Session* Scheduler::LiveSessionOf(UserId user, const std::string& rig_class) {
  for (auto& [id, session] : state_.sessions) {
    const bool person = session.kind == TicketKind::kPerson;
    if (!Ended(session) && person && session.user == user && session.rig_class == rig_class) {
      return &session;
    }
  }
  return nullptr;
}

Ticket* Scheduler::LiveTicketOf(UserId user, const std::string& rig_class) {
  for (auto& [id, ticket] : state_.tickets) {
    const bool person = ticket.kind == TicketKind::kPerson;
    if (!Ended(ticket) && person && ticket.user == user && ticket.rig_class == rig_class) {
      return &ticket;
    }
  }
  return nullptr;
}

/// A job is nobody.
bool Scheduler::SomebodyWaits(const std::string& rig_class, WallTime now) const {
  return std::ranges::any_of(state_.tickets, [&](const auto& entry) {
    const Ticket& ticket = entry.second;
    const bool waits = ticket.kind == TicketKind::kPerson &&
                       ticket.state == TicketState::kWaiting && ticket.rig_class == rig_class;
    if (!waits || state_.windows.empty()) return waits;
    const Milliseconds least = SettingsOf(rig_class).offer + ticket.min + policy_.cleaning;
    return now + least <= NextShut(state_, rig_class, ticket.courses, now);
  });
}

void Scheduler::Notify(UserId user, std::string topic, std::string text, SessionId session) {
  Notice notice;
  notice.user = user;
  notice.session = session;
  notice.topic = std::move(topic);
  notice.text = std::move(text);
  Notify(std::move(notice));
}

void Scheduler::Notify(Notice notice) {
  if (notice.user == UserId{}) return;  // guests get no messages
  const auto session = state_.sessions.find(notice.session);
  if (notice.rig.empty() && session != state_.sessions.end()) notice.rig = session->second.rig;
  notices_.push_back(std::move(notice));
}

Session& Scheduler::Hold(
    Rig& rig, UserId user, WallTime hard_end, Milliseconds claim_time, WallTime now) {
  LAB_CHECK(rig.status == RigStatus::kReady, rig.id, Name(rig.status));
  Session session;
  session.id = SessionId{NewNumber()};
  session.user = user;
  session.rig = rig.id;
  session.rig_class = rig.rig_class;
  session.start = now;
  session.hard_end = hard_end;
  session.claim_until = now + claim_time;
  session.last_control = now;
  session.charged_from = now;
  rig.status = RigStatus::kLeased;
  Touch(rig);
  Touch(session);
  return state_.sessions[session.id] = session;
}

void Scheduler::Activate(Session& session, WallTime now) {
  Rig& rig = *FindRig(session.rig);
  session.epoch = ++rig.epoch;
  session.state = SessionState::kActive;
  session.last_control = now;
  session.charged_from = now;
  Touch(rig);
  Touch(session);
}

void Scheduler::Charge(UserId user, Milliseconds use, WallTime now, bool in_week) {
  Usage& usage = state_.usage[user];
  const double past = DecayedUse(usage, now, policy_);
  usage.user = user;
  usage.seconds = past + std::max(0.0, std::chrono::duration<double>(use).count());
  usage.at = now;
  if (in_week) {
    if (std::exchange(usage.week, WeekOf(now)) != WeekOf(now)) usage.this_week = {};
    usage.this_week += std::max(Milliseconds{0}, use);
  }
  touched_users_.insert(user);
}

/// Ends every lease of the rig. A simulator is built anew for its next lease and needs no check.
void Scheduler::StartCleaning(Rig& rig, WallTime now) {
  ++rig.epoch;
  rig.status = rig.elastic ? RigStatus::kReady : RigStatus::kCleaning;
  rig.cleaning_due = now + policy_.cleaning_max;
  rig.reason = rig.elastic ? "" : "being checked";
  Touch(rig);
}

void Scheduler::ToMaintenance(Rig& rig, const std::string& reason) {
  rig.status = RigStatus::kMaintenance;
  rig.reason = reason;
  Touch(rig);
}

void Scheduler::Close(Session& session,
                      EndReason reason,
                      const std::string& text,
                      WallTime now,
                      const std::string& why) {
  Rig& rig = *FindRig(session.rig);
  const bool was_active = session.state == SessionState::kActive;
  const bool failed = reason == EndReason::kRigFailed;
  session.state = SessionState::kClosed;
  session.run_in_progress = false;
  session.end_reason = reason;
  session.end_text = text;
  session.ended = now;
  Touch(session);
  const auto booking = state_.bookings.find(session.booking);
  if (booking != state_.bookings.end()) {
    Booking& b = booking->second;
    ++b.version;
    Touch(b);
    if (was_active) {
      b.state = BookingState::kDone;
    } else if (reason == EndReason::kNoShow) {
      b.state = BookingState::kNoShow;
    } else if (failed) {
      b.state = BookingState::kBooked;  // the next tick plans another rig, if this one is out
      b.session = {};
    } else {
      b.state = BookingState::kCancelled;
    }
  }
  const auto ticket = state_.tickets.find(session.ticket);
  if (ticket != state_.tickets.end() && ticket->second.state == TicketState::kOffered) {
    Ticket& t = ticket->second;
    t.offered = {};
    const bool last_chance = reason == EndReason::kOfferMissed && ++t.offers_missed > 1;
    const bool given_back = reason == EndReason::kEnded;
    t.state = given_back    ? TicketState::kLeft
              : last_chance ? TicketState::kExpired
                            : TicketState::kWaiting;
    Touch(t);
  }
  if (was_active) {
    const bool practice = session.kind == TicketKind::kPractice;
    const bool in_week = session.kind == TicketKind::kPerson && !rig.elastic;
    if (!failed && !practice) Charge(session.user, now - session.charged_from, now, in_week);
    rig.wear += std::max(Milliseconds{0}, now - session.start);
    StartCleaning(rig, now);
  } else {
    rig.status = RigStatus::kReady;
    rig.reason.clear();
    Touch(rig);
  }
  const bool told = session.kind != TicketKind::kPractice;  // a run's page shows its end
  // "idle" alone is the question; this is the end that follows when it is not answered.
  const std::string topic(reason == EndReason::kIdle ? "idle_ended" : Name(reason));
  if (told) Notify({session.user, session.id, topic, text, session.rig, {}, why});
}

/// `to_the_last` tells the user who had the control until now.
void Scheduler::SwitchController(
    Session& session, UserId to, EndReason why, Notice to_the_last, WallTime now) {
  Charge(session.user, now - session.charged_from, now, !IsElastic(session.rig_class));
  if (Ticket* waiting = LiveTicketOf(to, session.rig_class)) {
    if (waiting->state == TicketState::kWaiting) waiting->state = TicketState::kLeft;
    Touch(*waiting);
  }
  to_the_last.user = session.user;
  to_the_last.session = session.id;
  to_the_last.other = to;
  Notify(std::move(to_the_last));
  session.user = to;
  session.offered_to = {};
  session.idle_answer_until.reset();
  session.end_reason = why;  // why the person before has it no more
  Activate(session, now);
  Notify(to, "control", "you have the control", session.id);
}

std::vector<Notice> Scheduler::TakeNotices() {
  return std::exchange(notices_, {});
}

Changes Scheduler::TakeChanges() {
  Changes changes;
  const auto stays = [](const auto&) { return false; };
  Collect(state_.rigs, touched_rigs_, changes.rigs, stays);
  Collect(state_.outages, touched_outages_, changes.outages, stays);
  Collect(state_.windows, touched_windows_, changes.windows, stays);
  const auto ended = [](const auto& entity) { return Ended(entity); };
  Collect(state_.tickets, touched_tickets_, changes.tickets, ended);
  Collect(state_.bookings, touched_bookings_, changes.bookings, ended);
  Collect(state_.sessions, touched_sessions_, changes.sessions, ended);
  Collect(state_.usage, touched_users_, changes.usage, stays);
  for (const std::string& rig_class : std::exchange(touched_settings_, {})) {
    const auto found = state_.settings.find(rig_class);
    auto& changed = changes.settings[rig_class];
    if (found != state_.settings.end()) changed = found->second;
  }
  changes.ended_outages = std::exchange(ended_outages_, {});
  changes.ended_windows = std::exchange(ended_windows_, {});
  changes.next_id = state_.next_id;
  return changes;
}

void Scheduler::ClockJumped(Milliseconds delta, WallTime now) {
  for (auto& [id, booking] : state_.bookings) {
    if (booking.state == BookingState::kBooked && booking.during.end <= now) {
      Unfulfil(booking, "clock", "");
    }
  }
  for (auto& [id, rig] : state_.rigs) {
    rig.cleaning_due += delta;
    Touch(rig);
  }
  for (auto& [id, session] : state_.sessions) {
    session.start += delta;
    session.hard_end += delta;
    session.claim_until += delta;
    session.last_control += delta;
    session.charged_from += delta;
    if (session.idle_answer_until) *session.idle_answer_until += delta;
    Touch(session);
  }
  for (auto& [id, ticket] : state_.tickets) {
    ticket.created += delta;
    if (ticket.expected) *ticket.expected += delta;
    if (ticket.first_expected) *ticket.first_expected += delta;
    Touch(ticket);
  }
  for (auto& [user, usage] : state_.usage) {
    usage.at += delta;
    touched_users_.insert(user);
  }
}

void Scheduler::StoodStill(Milliseconds length) {
  for (auto& [id, rig] : state_.rigs) {
    if (rig.status != RigStatus::kCleaning) continue;
    rig.cleaning_due += length;
    Touch(rig);
  }
  for (auto& [id, session] : state_.sessions) {
    session.last_control += length;
    if (session.state == SessionState::kHeld) session.claim_until += length;
    if (session.idle_answer_until) *session.idle_answer_until += length;
    Touch(session);
  }
}

/// A rig that was only held is checked, like a ready one, before anybody gets it. The user for whom
/// it was held is the next again.
void Scheduler::TakeBack(Session& session, WallTime now) {
  session.state = SessionState::kClosed;
  session.end_reason = EndReason::kRigFailed;
  session.end_text = "the server restarted: the rig is checked first";
  session.ended = now;
  Touch(session);
  const auto booking = state_.bookings.find(session.booking);
  if (booking != state_.bookings.end()) {
    booking->second.state = BookingState::kBooked;
    booking->second.session = {};
    ++booking->second.version;
    Touch(booking->second);
  }
  const auto ticket = state_.tickets.find(session.ticket);
  if (ticket != state_.tickets.end()) {
    ticket->second.state = TicketState::kWaiting;
    ticket->second.offered = {};
    Touch(ticket->second);
  }
  Rig& rig = *FindRig(session.rig);
  rig.status = RigStatus::kReady;
  Touch(rig);
}

void Scheduler::Recover(WallTime now, const std::string& server) {
  const auto ours = [&](const RigId& rig) {
    return server.empty() || state_.rigs.at(rig).server == server;
  };
  for (auto& [id, session] : state_.sessions) {
    if (session.state == SessionState::kClosed || !ours(session.rig)) continue;
    if (session.state == SessionState::kHeld) {
      TakeBack(session, now);
    } else if (session.kind == TicketKind::kPractice) {
      Close(session, EndReason::kRigFailed, "the server restarted", now);
    } else if (session.run_in_progress) {
      session.run_in_progress = false;
      session.charged_from = now;  // the interrupted run is not charged
      Notify(session.user, "interrupted", "the server restarted; your run was cut", id);
      Touch(session);
    }
  }
  for (auto& [id, rig] : state_.rigs) {
    if (!ours(id)) continue;
    if (rig.status == RigStatus::kCleaning || rig.status == RigStatus::kReady) {
      StartCleaning(rig, now);
    }
  }
}

}  // namespace faultlab::server::lab
