// Sessions and their leases.
#include <algorithm>
#include <utility>

#include "tests/world/oracle.h"
#include "tests/world/published_rules.h"

namespace faultlab::server::lab::rehearsal {
namespace {

std::string Text(SessionId id) {
  return "session " + std::to_string(Number(id));
}
std::string Text(UserId id) {
  return "user " + std::to_string(Number(id));
}
std::string SecondsText(Milliseconds time) {
  return std::to_string(time.count() / 1000) + " s";
}

}  // namespace

void Oracle::JudgeSessions(const Published& now, const Moment& moment) {
  just_begun_.clear();
  for (auto entry = known_.begin(); entry != known_.end();) {
    if (now.sessions.contains(entry->first)) {
      ++entry;
      continue;
    }
    JudgeGone(entry->first, entry->second, now, moment);
    entry = known_.erase(entry);
  }
  for (const auto& [id, session] : now.sessions) {
    const auto [entry, is_new] = known_.try_emplace(id);
    Known& known = entry->second;
    if (is_new) {
      JudgeNew(session, now);
      known.courses = CoursesOf(session.user);
      known.seen = moment.at;
      known.since = last_answer_;
      known.last = session;
      known.last.epoch = 0;
      known.last.state = SessionState::kHeld;
      known.deadline = moment.at + (session.hard_end - moment.lab);
      known.last_activity = moment.at;
      just_begun_.push_back(id);
    }
    JudgeLease(known, session, moment);
    JudgeEnd(known, session, now, moment);
    known.last = session;
  }
}

void Oracle::JudgeNew(const Session& session, const Published& now) {
  const auto rig = now.rigs.find(session.rig);
  if (rig == now.rigs.end()) return Broken("one holder", Text(session.id) + " has no rig");
  if (session.ticket != TicketId{}) served_.insert(session.ticket);
  for (const auto& [id, other] : now.sessions) {
    if (id == session.id) continue;
    if (other.rig == session.rig) {
      Broken("one holder", Text(id) + " and " + Text(session.id) + " are on " + session.rig);
    }
    const bool both = other.user == session.user && other.rig_class == session.rig_class &&
                      other.kind == TicketKind::kPerson && session.kind == TicketKind::kPerson;
    if (both) Broken("own session", Text(session.user) + " has two sessions in a class");
  }
  if (!rig->second.elastic && !rigs_[session.rig].checked) {
    Broken("check between users", session.rig + " is given to a user without a passed check");
  }
  const auto booked = now.bookings.find(session.booking);
  const bool checked = !rig->second.elastic && OwnNext(now, session) == BookingId{};
  if (booked != now.bookings.end() && !clock_set_ && checked &&
      session.hard_end > booked->second.during.end - kCleaning) {
    Broken("timeline", Text(session.id) + " takes the time of the check after its booking");
  }
  if (session.booking == BookingId{}) {
    const bool practice = session.kind == TicketKind::kPractice;  // no check follows it
    const Milliseconds check = practice ? Milliseconds{0} : Milliseconds{kCleaning};
    const WallTime next = NextOn(now, session.rig, session.start);
    const bool over = next != WallTime::max() && session.hard_end + check > next;
    const WallTime shut = ShutFrom(now, session.rig_class, CoursesOf(session.user), session.start);
    if (!clock_set_ && shut != WallTime::max() && session.hard_end + check > shut) {
      Broken("hours", Text(session.id) + " lasts into a time that is not for its user");
    }
    if (over && !clock_set_) {  // a step of the clock moves sessions and not bookings
      Broken("timeline",
             Text(session.id) + " leaves " + SecondsText(next - session.hard_end) +
                 " before a booking or an outage on " + session.rig);
    }
    const auto ticket = tickets_.find(session.ticket);
    const bool asked = ticket != tickets_.end();
    if (asked && session.hard_end - session.start < ticket->second.last.min) {
      Broken("timeline", Text(session.id) + " is shorter than its user can use");
    }
  }
  if (session.state == SessionState::kHeld && session.epoch != 0) {
    Broken("epochs rise", Text(session.id) + " has an epoch before it is accepted");
  }
}

/// A lease: the session became active, or its control was passed on.
void Oracle::JudgeLease(Known& known, const Session& session, const Moment& moment) {
  if (session.rig != known.last.rig) {
    Broken("one holder", Text(session.id) + " went to another rig");
  }
  if (session.state != SessionState::kActive) return;
  const bool began = known.last.state == SessionState::kHeld;
  const bool passed_on = !began && session.user != known.last.user;
  if (!began && !passed_on && session.epoch == known.last.epoch) return;
  KnownRig& rig = rigs_[session.rig];
  if (session.epoch <= rig.highest_lease) {
    Broken("epochs rise",
           Text(session.id) + " has epoch " + std::to_string(session.epoch) + " after " +
               std::to_string(rig.highest_lease) + " on " + session.rig);
  }
  rig.highest_lease = std::max(rig.highest_lease, session.epoch);
  rig.checked = false;
  if (began) {
    ++sessions_begun_;
    if (session.user != known.last.user) {
      Broken("hand-over", Text(session.id) + " was claimed by somebody else");
    }
  } else {
    if (!passed_on) Broken("epochs rise", Text(session.id) + " changed its epoch by itself");
    const bool offered = offered_[session.id] == session.user;
    if (passed_on && !offered && took_over_[session.id] != session.user) {
      Broken("hand-over", Text(session.id) + " went to a user who was not offered it");
    }
    // From now on it is theirs; who takes over only sees it to its end.
    if (passed_on && offered && took_over_[session.id] != session.user) {
      known.courses = CoursesOf(session.user);
    }
    EndLease(session.rig, known.last.epoch, moment);
    Charge(known, moment.at, !known.troubled && !Excused(moment.at));
  }
  offered_.erase(session.id);
  known.active_since = moment.at;
  known.last_activity = moment.at;
  known.idle_asked.reset();
  leases_[session.rig][session.epoch] = {session.id, session.user, {}};
}

/// A booking of the session's user on its rig that follows on it.
BookingId Oracle::OwnNext(const Published& now, const Session& session) {
  for (const auto& [id, booking] : now.bookings) {
    const bool own = booking.user == session.user && booking.rig == session.rig &&
                     booking.state == BookingState::kBooked;
    const Milliseconds ahead = booking.during.start - session.hard_end;
    if (own && ahead <= kCleaning && ahead >= -kCleaning) return id;
  }
  return {};
}

void Oracle::JudgeEnd(Known& known,
                      const Session& session,
                      const Published& now,
                      const Moment& moment) {
  known.troubled = known.troubled || Excused(moment.at);
  const RigStatus status = now.rigs.at(session.rig).status;
  if (status != RigStatus::kLeased) {
    Broken("health", Text(session.id) + " is on a rig that is " + std::string(Name(status)));
  }
  if (session.hard_end <= moment.lab) {
    Broken("hard end", Text(session.id) + " is shown after its end");
  }
  const WorldTime deadline = moment.at + (session.hard_end - moment.lab);
  const Milliseconds moved = deadline - known.deadline;
  const WorldTime before = std::exchange(known.deadline, deadline);
  const bool person = session.kind == TicketKind::kPerson;
  if (session.booking != known.last.booking) {
    known.extended = {};
    known.courses = CoursesOf(session.user);
  }
  const WallTime promised = NextOn(now, session.rig, session.hard_end);
  const WallTime shut = ShutFrom(now, session.rig_class, known.courses, moment.lab);
  const WallTime next = std::min(promised, shut);
  if (moved > kSlack && session.booking == known.last.booking) {
    // Into its user's own next hour is no extension.
    const bool goes_on = OwnNext(now, session) != BookingId{} && moved <= kIntoOwnBooking;
    if (!goes_on) known.extended += moved;
    if (known.extended > extended_max_ + kSlack) {
      Broken("extension",
             Text(session.id) + " was extended by " + SecondsText(known.extended) + " in all");
    }
    const bool said = told_extended_.contains(session.id) || asked_to_extend_.contains(session.id);
    if (!said) Broken("hard end", Text(session.id) + " ends later and nobody was told");
    if (before - moment.at > kNearEnd + kSlack) {
      Broken("extension",
             Text(session.id) + " was extended " + SecondsText(before - moment.at) +
                 " before its end");
    }
    if (moved > kExtension + kSlack && !Excused(moment.at)) {
      Broken("extension", Text(session.id) + " was extended by " + SecondsText(moved));
    }
    const WallTime others = NextOn(now, session.rig, session.hard_end, OwnNext(now, session));
    if (others != WallTime::max() && session.hard_end + kCleaning > others) {
      Broken("timeline", Text(session.id) + " was extended into a booking or an outage");
    }
    if (shut != WallTime::max() && !clock_set_ && session.hard_end + kCleaning > shut &&
        OwnNext(now, session) == BookingId{}) {
      Broken("hours", Text(session.id) + " was extended into a time that is not for its user");
    }
    // From now on, or from when the class opens for them, if the extension takes that time.
    const auto room_for = [&](const Ticket& ticket) {
      const Courses courses = CoursesOf(ticket.user);
      const WallTime open = OpenFrom(now, session.rig_class, courses, moment.lab);
      if (open >= session.hard_end + kCleaning - kSlack) return Milliseconds{0};
      const WallTime until = std::min(promised, ShutFrom(now, session.rig_class, courses, open));
      return until == WallTime::max() ? Milliseconds::max() : until - kCleaning - open;
    };
    for (const auto& [id, ticket] : now.tickets) {
      const bool waited = tickets_.contains(id) &&
                          tickets_.at(id).last.state == TicketState::kWaiting &&
                          ticket.state == TicketState::kWaiting;
      const bool fits = ticket.rig_class == session.rig_class &&
                        ticket.kind == TicketKind::kPerson &&
                        ticket.min + kCleaning <= room_for(ticket);
      if (waited && fits && !Excused(moment.at)) {
        Broken("extension",
               Text(session.id) + " was extended though ticket " + std::to_string(Number(id)) +
                   " waits and fits; room " +
                   SecondsText(std::min<Milliseconds>(room_for(ticket), std::chrono::hours(99))) +
                   ", min " + SecondsText(ticket.min));
        break;
      }
    }
  } else if (moved < -kSlack && !told_shortened_.contains(session.id)) {
    Broken("hard end", Text(session.id) + " ends " + SecondsText(-moved) + " earlier, untold");
  }
  if (session.state == SessionState::kHeld) {
    const bool booked = session.booking != BookingId{};
    if (moment.at - known.seen > (booked ? kGrace : kOffer) && !known.troubled) {
      Broken(booked ? "no-show" : "offer", Text(session.id) + " is held for too long");
    }
    return;
  }
  if (!person) return;
  const bool near_end = session.hard_end - moment.lab <= kNearEnd;
  if (near_end) ++known.near_end;
  const bool somebody = std::any_of(now.tickets.begin(), now.tickets.end(), [&](const auto& t) {
    return t.second.rig_class == session.rig_class && t.second.kind == TicketKind::kPerson &&
           t.second.state == TicketState::kWaiting;
  });
  const bool extendable =
      near_end && !somebody && known.extended + kExtensionLeast + kSlack < extended_max_ &&
      (next == WallTime::max() || next > session.hard_end + kCleaning + kExtensionLeast + kSlack);
  if (extendable && known.extendable && !Excused(moment.at)) {
    Broken("extension", Text(session.id) + " is not extended though nobody waits");
  }
  known.extendable = extendable;
  const bool idle = runs_[session.id] == 0 && moment.at - known.last_activity > kIdleForSure;
  if (!idle || known.troubled) return;
  for (const auto& [id, ticket] : now.tickets) {
    const bool waits = ticket.rig_class == session.rig_class &&
                       ticket.kind == TicketKind::kPerson &&
                       ticket.state == TicketState::kWaiting && ticket.offers_missed == 0;
    // They could have had the rig all this time, and still can.
    const WallTime shuts =
        ShutFrom(now, session.rig_class, CoursesOf(ticket.user), moment.lab - kIdleForSure);
    const bool may =
        shuts == WallTime::max() || shuts > moment.lab + kOffer + ticket.min + kCleaning + kSlack;
    if (waits && may && moment.lab - ticket.created > kIdleForSure) {
      Broken("idle",
             Text(session.id) + " is idle for " + SecondsText(moment.at - known.last_activity) +
                 " while ticket " + std::to_string(Number(id)) + " waits, and goes on");
      return;
    }
  }
}

void Oracle::JudgeGone(SessionId id, Known& known, const Published& now, const Moment& moment) {
  const Session& last = known.last;
  const auto found = end_topics_.find(id);
  const std::string topic = found == end_topics_.end() ? "" : found->second;
  const bool was_active = last.state == SessionState::kActive;
  const bool person = last.kind == TicketKind::kPerson;
  const bool excused = Excused(moment.at);
  const auto rig = now.rigs.find(last.rig);
  if (rig == now.rigs.end()) return Broken("one holder", "a rig is gone");
  const RigStatus status = rig->second.status;
  const bool usable = status == RigStatus::kReady || status == RigStatus::kLeased;
  if (was_active && usable && !rig->second.elastic) {
    Broken("check between users", last.rig + " is in use again without a check");
  }
  if (was_active) EndLease(last.rig, last.epoch, moment);
  const WorldTime slack = kSlack + (known.seen - known.since);
  if (topic == "expired") {
    if (known.deadline - moment.at > kSlack && !excused) {
      Broken("hard end",
             Text(id) + " expired " + SecondsText(known.deadline - moment.at) + " early");
    }
    if (person && was_active && known.near_end > 0 && !known.warned && !excused) {
      Broken("warning", Text(id) + " expired and its user was not warned");
    }
  } else if (topic == "idle_ended") {
    const auto is_shut = [&](const Ticket& ticket) {
      const WallTime before = moment.lab - kChunkLongest;
      const WallTime shut = ShutFrom(now, last.rig_class, CoursesOf(ticket.user), before);
      return shut <= before &&
             ShutFrom(now, last.rig_class, CoursesOf(ticket.user), moment.lab) <= moment.lab;
    };
    const bool waited = std::any_of(tickets_.begin(), tickets_.end(), [&](const auto& t) {
      return t.second.last.rig_class == last.rig_class &&
             t.second.last.kind == TicketKind::kPerson &&
             t.second.last.state == TicketState::kWaiting && !is_shut(t.second.last);
    });
    const bool asked = known.idle_asked && moment.at - *known.idle_asked >= kIdleAnswer - kSlack;
    const bool idle = moment.at - known.last_activity >= kIdle + kIdleAnswer - kSlack;
    if (runs_[id] > 0 && !excused)
      Broken("idle", Text(id) + " was closed as idle in the middle of a run");
    if (!idle && !known.troubled) Broken("idle", Text(id) + " was closed as idle and was not");
    if (!waited) Broken("idle", Text(id) + " was closed as idle though nobody waits");
    if (!asked) Broken("idle", Text(id) + " was closed as idle without 60 s to answer");
  } else if (topic == "no_show") {
    const bool late = moment.at - known.seen >= kGrace - slack;
    if (was_active || !late) Broken("no-show", Text(id) + " was taken as a no-show too early");
    used_[last.user].most_s += kNoShowCharge_s;
    used_[last.user].least_s += kNoShowCharge_s;
  } else if (topic == "offer_missed") {
    const bool late = moment.at - known.seen >= kOffer - slack;
    if (was_active || !late) Broken("offer", Text(id) + " was withdrawn too early");
  } else if (topic == "rig_failed") {
    const bool over = known.deadline <= moment.at + kSlack;  // held until an outage begins
    if (usable && !excused && !rig->second.elastic && !over) {
      Broken("health",
             Text(id) + " fell though its rig is " + std::string(Name(status)) + ": " +
                 end_texts_[id]);
    }
  } else if (topic == "ended" || topic == "operator" || topic == "booking_elsewhere") {
    const bool asked = topic != "booking_elsewhere" &&
                       (asked_to_end_.contains(id) || asked_to_leave_.contains(last.ticket) ||
                        asked_to_cancel_.contains(last.booking));
    const bool due = IsDue(now, last.user, last.rig_class, moment.lab) ||
                     IsDue(now, offered_[id], last.rig_class, moment.lab) ||
                     IsDue(now, took_over_[id], last.rig_class, moment.lab);
    if (!asked && !due)
      Broken("own session",
             Text(id) + ", " + std::string(Name(last.state)) +
                 ", was ended by nobody: " + end_texts_[id]);
  } else if (person && !(excused && !was_active)) {
    Broken("told", Text(id) + " is gone and its user was not told");
  }
  const bool surely = topic == "ended" || topic == "expired" || topic == "idle_ended" ||
                      topic == "booking_elsewhere";
  if (was_active && last.kind != TicketKind::kPractice) {
    Charge(known, moment.at, surely && !known.troubled && !excused);
  }
}

void Oracle::EndLease(const RigId& rig, std::uint64_t epoch, const Moment& moment) {
  Lease& lease = leases_[rig][epoch];
  lease.over = moment.at;
  lease.known_to[moment.member] = answers_;
  just_over_.emplace_back(rig, epoch);
}

void Oracle::Charge(const Known& known, WorldTime at, bool surely) {
  const double used_s = std::chrono::duration<double>(at - known.active_since).count();
  const double gap_s = std::chrono::duration<double>(known.seen - known.since + kSlack).count();
  Use& use = used_[known.last.user];
  use.most_s += used_s + gap_s;
  if (surely) use.least_s += std::max(0.0, used_s - gap_s);
}

}  // namespace faultlab::server::lab::rehearsal
