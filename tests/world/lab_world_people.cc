// What the people of a world do.
#include <algorithm>
#include <array>

#include "server/lab/opening.h"
#include "server/lab/timeline.h"
#include "tests/world/lab_world.h"
#include "tests/world/published_rules.h"

namespace faultlab::server::lab::rehearsal {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr std::size_t kCredentialsKept = 64;

/// The next of the times at which people book.
WallTime OnGrid(WallTime time) {
  const Milliseconds beyond = time.time_since_epoch() % Milliseconds(minutes(5));
  return time + (Milliseconds(minutes(5)) - beyond);
}

}  // namespace

void LabWorld::Person(WorldMember& member, double dice) {
  if (dice < 0.16) return AskForRig(member);
  if (dice < 0.32) return Accept(member);
  if (dice < 0.42) return Book(member);
  if (dice < 0.435) return BookWhatIsFree(member);
  if (dice < 0.53) return Claim(member);
  if (dice < 0.55) return Cancel(member);
  if (dice < 0.58) return End(member);
  if (dice < 0.62) return PassOn(member);
  if (dice < 0.65) return Extend(member);
  if (dice < 0.73) return Act(member);
  if (dice < 0.83) return Run(member);
  if (dice < 0.97) return member.CommandRun();
  if (dice < 0.98) return member.TryToCommand(AnyUser(), AnyRig());
  if (dice < 0.985) return member.RepeatOldCheck();
  // An operator puts right what stands in quarantine.
  const auto state = member.state();
  for (const auto& [id, rig] : state->rigs) {
    if (rig.status != RigStatus::kQuarantined) continue;
    (void)member.Do([&, &id = id](Scheduler& lab, WallTime now) { return lab.Release(id, now); });
    return;
  }
}

void LabWorld::AskForRig(WorldMember& member) {
  Random& random = site_.random;
  TicketRequest request;
  request.user = AnyUser();
  request.rig_class = AnyClass();
  request.courses = CoursesOf(request.user);
  request.kind = random.Chance(0.2) ? TicketKind::kJob : TicketKind::kPerson;
  const bool person = request.kind == TicketKind::kPerson;
  request.min =
      person ? random.Between(minutes(5), minutes(15)) : random.Between(minutes(1), minutes(5));
  request.want = request.min;
  if (person) {
    request.want += random.Between(Milliseconds{0}, minutes(30));
  } else {
    request.job = std::to_string(random.Below(100));
    request.weight = member.service().policy().job_weight_s;
  }
  const auto answer =
      member.Do([&](Scheduler& lab, WallTime now) { return lab.RequestTicket(request, now); });
  if (!answer || !answer->ok()) return;
  const auto state = member.state();
  if (person) {
    site_.oracle.Answered(request.user, request.rig_class, answer->value(), Published(*state));
  }
  const auto* ticket = std::get_if<Ticket>(&answer->value());
  for (const auto& [id, other] : state->tickets) {
    const bool same = !person && other.kind == TicketKind::kJob && other.user == request.user &&
                      other.job == request.job && ticket != nullptr && id != ticket->id &&
                      other.rig_class == request.rig_class;
    if (same) site_.oracle.Broken("one ticket", "a job waits twice");
  }
  if (const auto* session = std::get_if<Session>(&answer->value())) Remember(*session);
}

void LabWorld::Accept(WorldMember& member) {
  const auto state = member.state();
  TicketId id = AnyKey(site_.random, state->tickets);
  for (const auto& [ticket_id, ticket] : state->tickets) {
    const bool offered = ticket.state == TicketState::kOffered;
    if (offered && site_.random.Chance(0.4)) id = ticket_id;
  }
  const auto found = state->tickets.find(id);
  if (found == state->tickets.end()) return;
  if (site_.random.Chance(0.06)) {
    site_.oracle.AskedToLeave(id);
    (void)member.Do([&](Scheduler& lab, WallTime now) { return lab.LeaveTicket(id, now); });
    return;
  }
  const UserId user = site_.random.Chance(0.95) ? found->second.user : AnyUser();
  const auto session =
      member.Do([&](Scheduler& lab, WallTime now) { return lab.AcceptTicket(id, user, now); });
  if (!session || !session->ok()) return;
  Remember(session->value());
  if (user != found->second.user) {
    site_.oracle.Broken("hand-over", "a ticket was accepted by somebody else");
  }
}

void LabWorld::Book(WorldMember& member) {
  Random& random = site_.random;
  const Milliseconds ahead = random.Chance(0.5) ? Milliseconds(minutes(40)) : hours(4);
  const WallTime now = member.service().Now();
  const WallTime start = now + random.Between(-minutes(1), ahead);
  Interval during{start, start + random.Between(minutes(4), minutes(50))};
  if (random.Chance(0.6)) {  // as in the week grid of the page
    during.start = OnGrid(start);
    during.end = during.start + minutes(5) * (1 + random.Below(10));
  }
  const bool wait = random.Chance(0.4);
  std::string rig_class = AnyClass();
  const auto state = member.state();
  const auto others = state->bookings.find(AnyKey(random, state->bookings));
  if (wait && others != state->bookings.end() && random.Chance(0.5)) {  // many want the same
    during = others->second.during;
    rig_class = others->second.rig_class;
  }
  (void)member.Do([&, user = AnyUser()](Scheduler& lab, WallTime at) {
    return lab.Book(user, rig_class, during, at, CoursesOf(user), wait);
  });
}

/// What the calendar shows as free can be booked.
void LabWorld::BookWhatIsFree(WorldMember& member) {
  Random& random = site_.random;
  member.Turn();
  if (!member.awake()) return;
  const auto state = member.state();
  const WallTime now = member.service().Now();
  const std::string rig_class = AnyClass();
  const WallTime from = OnGrid(now + minutes(random.Below(120)));
  const Policy& policy = member.service().policy();
  std::vector<Interval> taken;
  for (const Shut& shut : ShutTimes(*state, rig_class, {}, {from, from + hours(6)})) {
    taken.push_back(shut.during);
  }
  std::optional<Interval> free;
  if (random.Chance(0.5)) {
    const Milliseconds step = minutes(random.Chance(0.5) ? 30 : 15);
    const auto slots =
        Availability(*state, rig_class, {from, from + hours(1)}, step, step, now, policy, taken);
    for (const Slot& slot : slots) {
      if (slot.free > 0) free = slot.during;
    }
  } else {
    const Milliseconds length = minutes(5 + random.Below(40));
    const auto starts =
        NextFree(*state, rig_class, {from, from + hours(4)}, length, 3, now, policy, taken);
    if (!starts.empty()) free = Interval{starts.back(), starts.back() + length};
  }
  if (!free) return;
  const UserId guest{1000};  // without any other booking
  const auto booked =
      member.Do([&](Scheduler& lab, WallTime at) { return lab.Book(guest, rig_class, *free, at); });
  if (!booked) return;
  if (!booked->ok()) {
    if (booked->error().code != core::ErrorCode::kConflict || booked->error().field != "start") {
      return;
    }
    site_.oracle.Broken("free is bookable",
                        "shown as free, and refused: " + booked->error().message);
    return;
  }
  const Booking& booking = booked->value();
  site_.oracle.AskedToCancel(booking.id);
  (void)member.Do([&](Scheduler& lab, WallTime at) {
    return lab.CancelBooking(booking.id, booking.version, at);
  });
}

void LabWorld::Claim(WorldMember& member) {
  const auto state = member.state();
  BookingId id = AnyKey(site_.random, state->bookings);
  for (const auto& [booking_id, booking] : state->bookings) {
    const bool held = booking.state == BookingState::kHeld;
    if (held && site_.random.Chance(0.5)) id = booking_id;
  }
  const auto found = state->bookings.find(id);
  if (found == state->bookings.end()) return;
  const Booking& booking = found->second;
  const UserId user = site_.random.Chance(0.95) ? booking.user : AnyUser();
  const auto session =
      member.Do([&](Scheduler& lab, WallTime now) { return lab.ClaimBooking(id, user, now); });
  if (!session) return;
  if (session->ok()) {
    Remember(session->value());
    if (user == booking.user) return;
    return site_.oracle.Broken("hand-over", "a booking was claimed by somebody else");
  }
  const bool early = user == booking.user && booking.state == BookingState::kBooked &&
                     booking.during.start > member.service().Now();
  const core::Error& error = session->error();
  const bool named = error.code == core::ErrorCode::kConflict && !error.parameters.empty();
  const bool known = error.code == core::ErrorCode::kNotFound;  // it fell meanwhile
  if (early && !named && !known) {
    site_.oracle.Broken("claimed early", "the refusal does not tell when: " + error.message);
  }
}

void LabWorld::Cancel(WorldMember& member) {
  const auto state = member.state();
  const BookingId id = AnyKey(site_.random, state->bookings);
  const auto found = state->bookings.find(id);
  if (found == state->bookings.end()) return;
  const std::int64_t read = found->second.version + site_.random.Below(2) - 1;
  site_.oracle.AskedToCancel(id);
  const auto done =
      member.Do([&](Scheduler& lab, WallTime now) { return lab.CancelBooking(id, read, now); });
  if (done && done->ok() && read < found->second.version) {
    site_.oracle.Broken("bookings kept", "cancelled by somebody who had read an old version");
  }
}

void LabWorld::End(WorldMember& member) {
  const auto state = member.state();
  const Session* session = AnySession(*state);
  if (session == nullptr) return;
  site_.oracle.AskedToEnd(session->id);
  const auto reason = site_.random.Chance(0.7) ? EndReason::kEnded : EndReason::kOperator;
  (void)member.Do([&](Scheduler& lab, WallTime now) {
    return lab.EndSession(session->id, reason, "rehearsal", now);
  });
  // Somebody who does not know yet.
  if (member.alive()) member.CommandRun();
}

void LabWorld::PassOn(WorldMember& member) {
  const auto state = member.state();
  const Session* session = AnySession(*state);
  if (session == nullptr) return;
  const SessionId id = session->id;
  const UserId to = AnyUser();
  std::optional<core::Result<Session>> passed;
  if (site_.random.Chance(0.15)) {
    site_.oracle.TookOver(id, to);
    passed = member.Do(
        [&](Scheduler& lab, WallTime now) { return lab.TakeOver(id, to, "rehearsal", now); });
  } else {
    if (site_.random.Chance(0.7)) {
      const auto offered =
          member.Do([&](Scheduler& lab, WallTime now) { return lab.OfferControl(id, to, now); });
      if (!offered || offered->ok()) site_.oracle.OfferedControl(id, to);
    }
    if (!member.alive() || site_.random.Chance(0.3)) return;
    passed = member.Do([&](Scheduler& lab, WallTime now) {
      return lab.AcceptControl(id, to, now, CoursesOf(to));
    });
  }
  if (!passed || !passed->ok()) return;
  Remember(passed->value());
  member.CommandRun();
}

void LabWorld::Extend(WorldMember& member) {
  const auto state = member.state();
  const Session* session = AnySession(*state);
  if (session == nullptr) return;
  site_.oracle.AskedToExtend(session->id);
  (void)member.Do([&](Scheduler& lab, WallTime now) { return lab.Extend(session->id, now); });
}

/// Signs of life, with epochs of any age.
void LabWorld::Act(WorldMember& member) {
  if (credentials_.empty()) return;
  const auto count = static_cast<std::int64_t>(credentials_.size());
  const Credential c = site_.random.Chance(0.4)
                           ? credentials_.back()
                           : credentials_[static_cast<std::size_t>(site_.random.Below(count))];
  if (site_.random.Chance(0.1)) {
    const auto there =
        member.Do([&](Scheduler& lab, WallTime now) { return lab.StillThere(c.session, now); });
    if (there && there->ok()) site_.oracle.Active(c.session, site_.now);
    return;
  }
  const auto done = member.Do(
      [&](Scheduler& lab, WallTime now) { return lab.ControlActivity(c.session, c.epoch, now); });
  const bool accepted = done && done->ok();
  if (!done || !member.alive()) return;
  const auto state = member.state();
  const auto session = state->sessions.find(c.session);
  const bool current = session != state->sessions.end() && session->second.epoch == c.epoch;
  if (!current) ++site_.report.stale_commands_tried;
  if (!accepted) return;
  if (!current) site_.oracle.Broken("stale command", "a sign of life with an old epoch counts");
  site_.oracle.Active(c.session, site_.now);
}

void LabWorld::Run(WorldMember& member) {
  const Milliseconds length =
      site_.random.Between(seconds(5), seconds(site_.random.Chance(0.15) ? 900 : 90));
  if (site_.random.Chance(0.2)) return member.BeginRun(AnyUser(), nullptr, length);
  const auto state = member.state();
  const Session* session = AnySession(*state);
  if (session == nullptr || session->state != SessionState::kActive) return;
  if (state->rigs.at(session->rig).server != member.id()) return;
  if (session->kind == TicketKind::kPractice) return;
  const bool spectator = site_.random.Chance(0.05);
  member.BeginRun(spectator ? AnyUser() : session->user, session, length);
}

void LabWorld::Remember(const Session& session) {
  if (session.epoch == 0) return;
  credentials_.push_back({session.id, session.epoch});
  if (credentials_.size() > kCredentialsKept) credentials_.erase(credentials_.begin());
}

}  // namespace faultlab::server::lab::rehearsal
