// Rules 3, 4, 11 and 12 of the README: one fair queue per class, elastic simulators, jobs in gaps.
#include <algorithm>
#include <iterator>
#include <span>

#include "server/lab/fair_order.h"
#include "server/lab/opening.h"
#include "server/lab/policy_settings.h"
#include "server/lab/scheduler.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab {

/// The future of one rig while estimating: busy intervals in order, and the time from which it is
/// free.
struct Scheduler::Lane {
  WallTime free_at{};
  std::vector<Interval> busy;
};

namespace {

using core::Done;
using core::ErrorCode;

/// Estimates are given in steps of 10 s, so that a queue in which only time passes is not written.
constexpr Milliseconds kEstimateGrid{10'000};
constexpr WallTime kNever = WallTime::max();

WallTime RoundUp(WallTime time) {
  const auto beyond = time.time_since_epoch() % kEstimateGrid;
  return beyond == Milliseconds{0} ? time : time + (kEstimateGrid - beyond);
}

/// The first time at which `length` and the cleaning after it fit between what is `busy`, in order.
WallTime FirstFit(WallTime free_at,
                  std::span<const Interval> busy,
                  Milliseconds length,
                  Milliseconds cleaning) {
  WallTime start = free_at;
  for (const Interval& each : busy) {
    if (each.end <= start) continue;
    if (each.start >= start + length + cleaning) break;
    start = each.end;
  }
  return start;
}

}  // namespace

core::Result<TicketAnswer> Scheduler::RequestTicket(const TicketRequest& request, WallTime now) {
  if (!HasClass(state_, request.rig_class)) return core::Refuse("no_rig_class", "rig_class");
  const PolicySettings& settings = SettingsOf(request.rig_class);
  const bool person = request.kind == TicketKind::kPerson;
  if (request.min <= Milliseconds{0} || (person && request.min < settings.session_min)) {
    return core::Refuse("minutes_short",
                        "min_minutes",
                        {{"least", settings.session_min / std::chrono::minutes(1)}});
  }
  if (request.want < request.min || request.want > settings.session_max) {
    return core::Refuse("minutes_outside",
                        "want_minutes",
                        {{"most", settings.session_max / std::chrono::minutes(1)}});
  }
  if (person) {
    const Session* own = LiveSessionOf(request.user, request.rig_class);
    if (own != nullptr && own->ticket == TicketId{}) return TicketAnswer{*own};
    if (own != nullptr && own->state == SessionState::kActive) return TicketAnswer{*own};
    if (const Ticket* live = LiveTicketOf(request.user, request.rig_class)) {
      return TicketAnswer{*live};
    }
  } else {
    for (const auto& [id, session] : state_.sessions) {
      const bool own = session.kind == TicketKind::kJob && session.user == request.user;
      if (own && session.state != SessionState::kClosed && session.job == request.job) {
        return TicketAnswer{session};
      }
    }
    int waiting = 0;
    for (const auto& [id, ticket] : state_.tickets) {
      if (ticket.kind != TicketKind::kJob || ticket.user != request.user) continue;
      if (ticket.job == request.job) return TicketAnswer{ticket};
      if (ticket.rig_class == request.rig_class) ++waiting;
    }
    if (waiting >= settings.waiting_jobs_max) {
      return core::Refuse("waiting_jobs_full").As(ErrorCode::kBusy);
    }
  }
  if (person) {
    TRY_DONE(CheckWeek(request.user, request.rig_class, request.min, now));
  }
  Ticket ticket;
  ticket.id = TicketId{NewNumber()};
  ticket.user = request.user;
  ticket.rig_class = request.rig_class;
  ticket.kind = request.kind;
  ticket.job = request.job;
  ticket.weight = request.weight;
  ticket.min = request.min;
  ticket.want = request.want;
  ticket.created = now;
  ticket.courses = request.courses;
  state_.tickets[ticket.id] = ticket;
  Touch(ticket);
  Tick(now);
  const Ticket& placed = state_.tickets.at(ticket.id);
  if (placed.state == TicketState::kClaimed) {
    return TicketAnswer{state_.sessions.at(placed.offered)};
  }
  return TicketAnswer{placed};
}

core::Result<Session> Scheduler::AcceptTicket(TicketId id, UserId user, WallTime now) {
  Tick(now);
  const auto found = state_.tickets.find(id);
  if (found == state_.tickets.end() || found->second.user != user) {
    return core::Refuse("no_ticket");
  }
  Ticket& ticket = found->second;
  Session* session = FindLive(ticket.offered);
  if (ticket.state == TicketState::kClaimed && session != nullptr) return *session;
  if (ticket.state != TicketState::kOffered || session == nullptr) {
    return core::Refuse("nothing_offered");
  }
  ticket.state = TicketState::kClaimed;
  Touch(ticket);
  Activate(*session, now);
  return *session;
}

core::Status Scheduler::LeaveTicket(TicketId id, WallTime now) {
  const auto found = state_.tickets.find(id);
  if (found == state_.tickets.end()) {
    return core::Refuse("no_ticket");
  }
  Ticket& ticket = found->second;
  if (ticket.state == TicketState::kOffered) {
    Close(*FindLive(ticket.offered), EndReason::kEnded, "the offer was declined", now);
  } else if (ticket.state == TicketState::kWaiting) {
    ticket.state = TicketState::kLeft;
    ticket.place = 0;
    Touch(ticket);
  } else {
    return core::Refuse("no_ticket").As(ErrorCode::kConflict);
  }
  Tick(now);
  return Done{};
}

core::Status Scheduler::DropJob(const std::string& job, WallTime now) {
  for (auto& [id, ticket] : state_.tickets) {
    const bool waits = ticket.kind == TicketKind::kJob && ticket.state == TicketState::kWaiting;
    if (!waits || ticket.job != job) continue;
    ticket.state = TicketState::kLeft;
    ticket.place = 0;
    Touch(ticket);
  }
  for (auto& [id, session] : state_.sessions) {
    const bool runs = session.kind == TicketKind::kJob && session.state != SessionState::kClosed;
    if (runs && session.job == job) Close(session, EndReason::kEnded, "the job is over", now);
  }
  Tick(now);
  return Done{};
}

bool Scheduler::OfferTo(Ticket& ticket, WallTime now) {
  // The user may have got a session in another way (passed on, booking): rule 4.
  const bool person = ticket.kind == TicketKind::kPerson;
  if (person && LiveSessionOf(ticket.user, ticket.rig_class) != nullptr) return false;
  const PolicySettings& settings = SettingsOf(ticket.rig_class);
  Rig* best = nullptr;
  WallTime best_end{};
  for (auto& [id, rig] : state_.rigs) {
    if (rig.rig_class != ticket.rig_class || rig.status != RigStatus::kReady) continue;
    const Milliseconds claim = person && !rig.elastic ? settings.offer : Milliseconds{0};
    const WallTime next = RoomUntil(rig, ticket.courses, now);
    const WallTime limit = next == kNever ? kNever : next - policy_.cleaning;
    if (limit < now + claim + ticket.min) continue;
    if (best != nullptr && best->wear <= rig.wear) continue;
    best = &rig;
    best_end = std::min(now + claim + ticket.want, limit);
  }
  if (best == nullptr) return false;
  const bool at_once = !person || best->elastic;
  if (person && !best->elastic && settings.week_max > Milliseconds{0}) {
    // The week had room for the least when the ticket was made; a ticket once taken is served.
    const Milliseconds left = settings.week_max - WeekUse(ticket.user, now);
    best_end = std::min(best_end, now + settings.offer + std::max(ticket.min, left));
  }
  Session& session = Hold(*best, ticket.user, best_end, settings.offer, now);
  session.ticket = ticket.id;
  session.kind = ticket.kind;
  session.job = ticket.job;
  session.courses = ticket.courses;
  ticket.offered = session.id;
  ticket.place = 0;
  ticket.state = at_once ? TicketState::kClaimed : TicketState::kOffered;
  Touch(ticket);
  if (at_once) {
    Activate(session, now);
  } else {
    Notify(ticket.user,
           "offer",
           "a rig is yours: accept within " + LengthText(settings.offer),
           session.id);
  }
  return true;
}

void Scheduler::Dispatch(WallTime now) {
  std::vector<std::string> classes;
  for (const auto& [id, rig] : state_.rigs) {
    if (rig.status == RigStatus::kReady) classes.push_back(rig.rig_class);
  }
  std::sort(classes.begin(), classes.end());
  classes.erase(std::unique(classes.begin(), classes.end()), classes.end());
  for (const auto& rig_class : classes) {
    for (const TicketId id : QueueOrder(state_, rig_class, now, policy_)) {
      OfferTo(state_.tickets.at(id), now);
    }
  }
}

void Scheduler::Estimate(WallTime now) {
  std::vector<std::string> classes;
  for (const auto& [id, ticket] : state_.tickets) {
    if (ticket.state == TicketState::kWaiting) classes.push_back(ticket.rig_class);
  }
  std::sort(classes.begin(), classes.end());
  classes.erase(std::unique(classes.begin(), classes.end()), classes.end());
  for (const auto& rig_class : classes) {
    std::vector<Lane> lanes;
    for (const auto& [id, rig] : state_.rigs) {
      if (rig.rig_class != rig_class || !Promising(state_, rig, now)) continue;
      Lane lane{now, BusyIntervals(state_, id, policy_)};
      if (rig.status == RigStatus::kCleaning) {
        // A check is expected to take its usual time, not its time limit.
        lane.free_at = now + policy_.cleaning;
        std::erase_if(lane.busy,
                      [due = rig.cleaning_due](const Interval& busy) { return busy.end == due; });
      }
      lanes.push_back(std::move(lane));
    }
    const std::vector<TicketId> order = QueueOrder(state_, rig_class, now, policy_);
    const auto expected = ExpectedStarts(std::move(lanes), order, now);
    int place = 0;
    for (const TicketId id : order) {
      Ticket& ticket = state_.tickets.at(id);
      ++place;
      if (ticket.place == place && ticket.expected == expected.at(id)) continue;
      const bool moved = ticket.place != place;
      ticket.place = place;
      ticket.expected = expected.at(id);
      if (!ticket.first_expected) ticket.first_expected = ticket.expected;
      Touch(ticket);
      if (moved) Notify(ticket.user, "place", std::to_string(place));
    }
  }
}

/// As they will be served: whoever can begin first, and of those the first in the order.
std::map<TicketId, std::optional<WallTime>> Scheduler::ExpectedStarts(
    std::vector<Lane> lanes, const std::vector<TicketId>& order, WallTime now) const {
  /// Who needs the same, in the order, and when each rig has no room for them.
  struct Group {
    std::vector<std::vector<Interval>> busy;
    std::vector<std::pair<std::size_t, const Ticket*>> tickets;
    std::size_t served = 0;
  };
  const Interval ahead{now, now + kExpectedWithin};
  const bool has_hours = std::ranges::any_of(state_.windows, [&](const auto& each) {
    return !order.empty() && each.second.rig_class == state_.tickets.at(order.front()).rig_class;
  });
  std::map<std::pair<Courses, Milliseconds>, Group> groups;
  for (std::size_t place = 0; place < order.size(); ++place) {
    const Ticket& ticket = state_.tickets.at(order[place]);
    // Without hours nobody fits never: one line, in its order.
    const auto need =
        has_hours ? std::pair(ticket.courses, ticket.min) : std::pair(Courses{}, Milliseconds{0});
    const auto [entry, is_new] = groups.try_emplace(need);
    Group& group = entry->second;
    group.tickets.emplace_back(place, &ticket);
    if (!is_new) continue;
    std::vector<Interval> shut;
    for (const Shut& each : ShutTimes(state_, ticket.rig_class, ticket.courses, ahead)) {
      shut.push_back(each.during);
    }
    std::ranges::sort(shut);
    for (const Lane& lane : lanes) {
      std::vector<Interval>& busy = group.busy.emplace_back();
      std::ranges::merge(lane.busy, shut, std::back_inserter(busy));
    }
  }
  struct Start {
    WallTime at = kNever;
    std::size_t place = 0;
    std::size_t lane = 0;
    Group* group = nullptr;
  };
  std::map<TicketId, std::optional<WallTime>> expected;
  for (const TicketId id : order) expected[id];
  for (std::size_t left = order.size(); left > 0; --left) {
    Start first;
    for (auto& [need, group] : groups) {
      if (group.served == group.tickets.size()) continue;
      const auto& [place, ticket] = group.tickets[group.served];
      const Milliseconds least = ticket->min + SettingsOf(ticket->rig_class).offer;
      for (std::size_t i = 0; i < lanes.size(); ++i) {
        const WallTime at = FirstFit(lanes[i].free_at, group.busy[i], least, policy_.cleaning);
        const bool sooner = at < first.at || (at == first.at && place < first.place);
        if (sooner) first = {at, place, i, &group};
      }
    }
    if (first.group == nullptr || first.at >= ahead.end) break;
    const Ticket& ticket = *first.group->tickets[first.group->served++].second;
    expected[ticket.id] = RoundUp(first.at);
    // It ends where something else begins.
    WallTime end = first.at + ticket.want + policy_.cleaning;
    for (const Interval& each : first.group->busy[first.lane]) {
      if (each.start > first.at) end = std::min(end, each.start);
    }
    lanes[first.lane].free_at = end;
  }
  return expected;
}

}  // namespace faultlab::server::lab
