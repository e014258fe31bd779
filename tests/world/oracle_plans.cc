// Bookings, tickets and the order of the queue.
#include <algorithm>
#include <cmath>
#include <variant>

#include "tests/world/oracle.h"
#include "tests/world/published_rules.h"

namespace faultlab::server::lab::rehearsal {
namespace {

std::string Text(BookingId id) {
  return "booking " + std::to_string(Number(id));
}
std::string Text(TicketId id) {
  return "ticket " + std::to_string(Number(id));
}

double Bonus(double use_s) {
  return kFreshBonus_s * std::exp2(-use_s / kQuota_s);
}

}  // namespace

/// The next thing that is promised on the rig: a booking or an outage. One that is due and waits
/// for the rig counts as beginning now.
WallTime Oracle::NextOn(const Published& now,
                        const RigId& rig,
                        WallTime from,
                        BookingId without) const {
  WallTime next = WallTime::max();
  for (const auto& [id, booking] : now.bookings) {
    if (id == without || booking.state != BookingState::kBooked || booking.rig != rig) continue;
    next = std::min(next, std::max(from, booking.during.start));
  }
  for (const auto& [id, outage] : now.outages) {
    if (outage.rig != rig || outage.during.end <= from) continue;
    next = std::min(next, std::max(from, outage.during.start));
  }
  return next;
}

bool Oracle::HasSession(const Published& now, UserId user, const std::string& rig_class) const {
  return std::any_of(now.sessions.begin(), now.sessions.end(), [&](const auto& entry) {
    const Session& session = entry.second;
    return session.user == user && session.rig_class == rig_class &&
           session.kind == TicketKind::kPerson;
  });
}

/// Whether a ready rig has nothing else to do until the end of the booking.
bool Oracle::EqualRigIsFree(const Published& now, const Booking& booking, WallTime lab) const {
  return std::any_of(now.rigs.begin(), now.rigs.end(), [&](const auto& rig) {
    return rig.second.rig_class == booking.rig_class && rig.second.status == RigStatus::kReady &&
           NextOn(now, rig.first, lab, booking.id) >= booking.during.end;
  });
}

/// Whether a booking of this user has begun.
bool Oracle::IsDue(const Published& now,
                   UserId user,
                   const std::string& rig_class,
                   WallTime lab) const {
  const auto due = [&](const Booking& booking) {
    return booking.user == user && booking.rig_class == rig_class && booking.during.start <= lab;
  };
  return std::any_of(now.bookings.begin(),
                     now.bookings.end(),
                     [&](const auto& entry) { return due(entry.second); }) ||
         std::any_of(bookings_.begin(), bookings_.end(), [&](const auto& entry) {
           return due(entry.second.last);
         });
}

/// When people of these courses may not be on a rig of the class: it opens and closes where some
/// time begins or ends. Hours have an id for ever, so what was worked out for them stays true.
const std::vector<Interval>& Oracle::ShutOf(const Published& now,
                                            const std::string& rig_class,
                                            const Courses& courses) {
  std::vector<WindowId> ids;
  for (const auto& [id, window] : now.windows) ids.push_back(id);
  if (ids != shut_by_) shut_.clear();
  shut_by_ = std::move(ids);
  const auto [entry, is_new] = shut_.try_emplace({rig_class, courses});
  std::vector<Interval>& shut = entry->second;
  if (!is_new) return shut;
  std::set<WallTime> borders{WallTime::min(), WallTime::max()};
  bool has_hours = false;
  for (const auto& [id, window] : now.windows) {
    if (window.rig_class != rig_class) continue;
    has_hours = has_hours || window.course == 0;
    for (const Interval& time : window.times) {
      borders.insert(time.start);
      borders.insert(time.end);
    }
  }
  const auto is_open = [&](WallTime at) {
    bool open = !has_hours;
    for (const auto& [id, window] : now.windows) {
      if (window.rig_class != rig_class) continue;
      const auto within = [&](const Interval& t) { return t.start <= at && at < t.end; };
      if (!std::any_of(window.times.begin(), window.times.end(), within)) continue;
      const bool theirs = window.course == 0 ||
                          std::find(courses.begin(), courses.end(), window.course) != courses.end();
      if (!theirs) return false;
      open = true;
    }
    return open;
  };
  for (auto from = borders.begin(); *from != WallTime::max(); ++from) {
    if (!is_open(*from)) shut.push_back({*from, *std::next(from)});
  }
  return shut;
}

WallTime Oracle::ShutFrom(const Published& now,
                          const std::string& rig_class,
                          const Courses& courses,
                          WallTime from) {
  const std::vector<Interval>& shut = ShutOf(now, rig_class, courses);
  const auto next = std::partition_point(
      shut.begin(), shut.end(), [&](const Interval& each) { return each.end <= from; });
  return next == shut.end() ? WallTime::max() : std::max(from, next->start);
}

WallTime Oracle::OpenFrom(const Published& now,
                          const std::string& rig_class,
                          const Courses& courses,
                          WallTime from) {
  for (const Interval& each : ShutOf(now, rig_class, courses)) {
    if (each.start <= from && from < each.end) from = each.end;
  }
  return from;
}

bool Oracle::Fits(const Published& now, const Rig& rig, const Ticket& ticket, WallTime lab) {
  const WallTime next =
      std::min(NextOn(now, rig.id, lab), ShutFrom(now, rig.rig_class, CoursesOf(ticket.user), lab));
  if (next == WallTime::max()) return true;
  const bool at_once = ticket.kind == TicketKind::kJob || rig.elastic;
  return lab + (at_once ? Milliseconds{0} : kOffer) + ticket.min + kCleaning <= next;
}

/// Who waits for a time gets it when a rig is free then, in the order of asking, and is told.
/// Before JudgeBookings: what is known is of the answer before.
void Oracle::JudgeWaiting(const Published& now, const Moment& moment) {
  const auto waits = [](const Booking& booking) { return booking.state == BookingState::kWaiting; };
  const auto is_free = [&](const Rig& rig, const Interval& during) {
    const bool well = rig.status == RigStatus::kReady || rig.status == RigStatus::kLeased;
    if (!well || NextOn(now, rig.id, during.start) < during.end) return false;
    for (const auto& [id, other] : now.bookings) {
      const bool booked = other.state == BookingState::kBooked && other.rig == rig.id;
      if (booked && other.during.Overlaps(during)) return false;
    }
    return std::none_of(now.sessions.begin(), now.sessions.end(), [&](const auto& entry) {
      const Session& session = entry.second;
      return session.rig == rig.id &&
             std::max(session.hard_end, moment.lab) + kCleaning > during.start;
    });
  };
  for (const auto& [id, booking] : now.bookings) {
    if (!waits(booking)) continue;
    int& answers = bookings_[id].waits_for_free;
    const WallTime shut =
        ShutFrom(now, booking.rig_class, CoursesOf(booking.user), booking.during.start);
    const auto of_class = [&, &booking = booking](const Rig& rig) {
      return rig.rig_class == booking.rig_class;
    };
    const auto free =
        std::count_if(now.rigs.begin(), now.rigs.end(), [&, &booking = booking](const auto& entry) {
          return of_class(entry.second) && is_free(entry.second, booking.during);
        });
    // A promise whose own rig is out comes first.
    const auto promised = std::count_if(
        now.bookings.begin(), now.bookings.end(), [&, &booking = booking](const auto& entry) {
          const Booking& other = entry.second;
          const auto rig = now.rigs.find(other.rig);
          const bool out = rig == now.rigs.end() || rig->second.status == RigStatus::kOffline ||
                           rig->second.status == RigStatus::kQuarantined ||
                           rig->second.status == RigStatus::kMaintenance;
          return other.state == BookingState::kBooked && other.rig_class == booking.rig_class &&
                 other.during.Overlaps(booking.during) && out;
        });
    const bool in_time = booking.during.start > moment.lab + kGivenAhead + kSlack;
    answers = free > promised && in_time && shut >= booking.during.end ? answers + 1 : 0;
    if (answers == 2) Broken("waiting for a time", Text(id) + " waits, and a rig is free then");
    if (booking.during.start + kSlack < moment.lab + kGivenAhead) {
      Broken("waiting for a time", Text(id) + " waits for a time that begins soon");
    }
  }
  for (const auto& [id, known] : bookings_) {
    if (!waits(known.last)) continue;
    const Booking& last = known.last;
    const auto entry = now.bookings.find(id);
    if (entry != now.bookings.end() && waits(entry->second)) continue;
    if (asked_to_cancel_.contains(id)) continue;
    if (told_time_[last.user]-- <= 0 && !Excused(moment.at)) {
      Broken("waiting for a time", Text(id) + " no longer waits, and its user was not told");
    }
    told_time_[last.user] = std::max(0, told_time_[last.user]);
    if (entry == now.bookings.end()) {
      if (last.during.start > moment.lab + kGivenAhead + kSlack && !Excused(moment.at)) {
        Broken("waiting for a time", Text(id) + " is gone before its time");
      }
      continue;
    }
    if (last.during.start + kSlack < moment.lab + kGivenAhead) {
      Broken("waiting for a time", Text(id) + " is given too late to know");
    }
    for (const auto& [other_id, other] : now.bookings) {
      const bool passed_over = other_id < id && waits(other) && other.during == last.during &&
                               other.rig_class == last.rig_class &&
                               CoursesOf(other.user) == CoursesOf(last.user);
      if (passed_over) Broken("waiting for a time", Text(id) + " overtakes " + Text(other_id));
    }
  }
}

void Oracle::JudgeBookings(const Published& now, const Moment& moment) {
  for (const auto& [id, booking] : now.bookings) {
    const auto [entry, is_new] = bookings_.try_emplace(id);
    KnownBooking& known = entry->second;
    const bool booked = booking.state == BookingState::kBooked;
    const bool planned = booked && (is_new || known.last.rig != booking.rig);
    const bool given = booked && (is_new || known.last.state == BookingState::kWaiting);
    known.last = booking;
    if (booking.state == BookingState::kWaiting) continue;
    const bool excused = RigsExcused(booking.rig_class, moment.at);
    const Courses courses = CoursesOf(booking.user);
    if (given &&
        ShutFrom(now, booking.rig_class, courses, booking.during.start) < booking.during.end) {
      Broken("hours", Text(id) + " is in a time that is not for its user");
    }
    if (planned && !booking.rig.empty() && !excused) {
      for (const auto& [other_id, other] : now.bookings) {
        if (other_id == id || other.state != BookingState::kBooked || other.rig != booking.rig) {
          continue;
        }
        if (other.during.Overlaps(booking.during)) {
          Broken("timeline", Text(id) + " and " + Text(other_id) + " are both on " + booking.rig);
        }
      }
      for (const auto& [session_id, session] : now.sessions) {
        if (session.rig != booking.rig || session.hard_end + kCleaning <= booking.during.start) {
          continue;
        }
        Broken("timeline", Text(id) + " is planned into a session on " + booking.rig);
      }
    }
    if (!booked) {
      known.due.reset();
      const auto session = now.sessions.find(booking.session);
      if (session == now.sessions.end() || session->second.user == UserId{}) {
        Broken("bookings kept", Text(id) + " is said to have a rig and has none");
      }
      continue;
    }
    const auto planned_on = now.rigs.find(booking.rig);
    const bool dead =
        planned_on != now.rigs.end() && (planned_on->second.status == RigStatus::kOffline ||
                                         planned_on->second.status == RigStatus::kQuarantined);
    const bool soon = booking.during.start < moment.lab + kMovedAhead;
    const bool equal = dead && soon && EqualRigIsFree(now, booking, moment.lab);
    known.on_dead_rig = equal ? known.on_dead_rig + 1 : 0;
    if (known.on_dead_rig == 3) {
      Broken("bookings kept", Text(id) + " stays on a rig that does not work");
    }
    if (booking.during.start > moment.lab) continue;
    const bool ready = std::any_of(
        now.rigs.begin(), now.rigs.end(), [&, &id = id, &booking = booking](const auto& rig) {
          if (rig.second.status != RigStatus::kReady) return false;
          if (rig.second.rig_class != booking.rig_class) return false;
          return rig.first == booking.rig ||
                 NextOn(now, rig.first, moment.lab, id) >= booking.during.end;
        });
    if (!known.due) known.due = moment.at;
    const bool own = HasSession(now, booking.user, booking.rig_class);
    known.beside_ready = ready && !own ? known.beside_ready + 1 : 0;
    if (known.beside_ready == 3) {
      Broken("bookings kept", Text(id) + " is due, a rig is ready, and its user does not get it");
    }
    if (moment.at - *known.due > kDueFor && !own && !excused) {
      Broken("bookings kept",
             Text(id) + " is due and has no rig, though every rig is well; " + booking.rig +
                 " is " +
                 std::string(booking.rig.empty() ? "none" : Name(now.rigs.at(booking.rig).status)));
      known.due = moment.at + kPlansLast;  // one finding
    }
  }
  for (auto entry = bookings_.begin(); entry != bookings_.end();) {
    const auto& [id, known] = *entry;
    if (now.bookings.contains(id)) {
      ++entry;
      continue;
    }
    const Booking& last = known.last;
    if (last.state == BookingState::kBooked && !asked_to_cancel_.contains(id)) {
      int& told = told_unfulfilled_[last.user];
      const bool excused = RigsExcused(last.rig_class, moment.at);
      if (told <= 0 && Excused(moment.at)) {
        // It became part of a session that fell with its rig in the same turn.
      } else if (told <= 0) {
        Broken("bookings kept", Text(id) + " is gone and its user was not told");
      } else if (!excused) {
        Broken("bookings kept", Text(id) + " fell though every rig was well");
      }
      const bool free = EqualRigIsFree(now, last, moment.lab);
      if (free && last.during.end - kCleaning > moment.lab && !Excused(moment.at)) {
        Broken("bookings kept", Text(id) + " fell though an equal rig is free");
      }
      told = std::max(0, told - 1);
    }
    if (last.state == BookingState::kHeld && !asked_to_cancel_.contains(id)) {
      const auto end = end_topics_.find(last.session);
      const bool ended = end != end_topics_.end() &&
                         (end->second == "no_show" || asked_to_end_.contains(last.session));
      if (!ended && !RigsExcused(last.rig_class, moment.at)) {
        Broken("bookings kept", Text(id) + " was taken from its user before the grace was over");
      }
    }
    entry = bookings_.erase(entry);
  }
}

double Oracle::MostScore(const KnownTicket& ticket, WorldTime at) const {
  const auto used = used_.find(ticket.last.user);
  double use_s = used == used_.end() ? 0.0 : used->second.least_s;
  use_s *= std::exp2(-Seconds(at) / kHalfLife_s);
  return Seconds(at - ticket.created) + Bonus(use_s) + ticket.last.weight;
}

double Oracle::LeastScore(const KnownTicket& ticket, WorldTime at) const {
  const auto used = used_.find(ticket.last.user);
  const double use_s = used == used_.end() ? 0.0 : used->second.most_s;
  return Seconds(at - ticket.created) + Bonus(use_s) + ticket.last.weight;
}

/// @param slack  more than 0: perhaps; less: for sure
bool Oracle::KeepsPlace(const KnownTicket& ticket, const Moment& moment, Milliseconds slack) {
  return ticket.last.kind == TicketKind::kPerson && ticket.last.first_expected &&
         moment.at - ticket.created >= kAskedTogether - slack &&
         *ticket.last.first_expected <= moment.lab + kKeepsPlace + slack;
}

/// Who got a rig in this answer must not have been behind somebody who still waits and fits.
void Oracle::JudgeOrder(const Published& now, const Moment& moment) {
  for (const SessionId id : just_begun_) {
    const Session& session = now.sessions.at(id);
    if (session.ticket == TicketId{} || Excused(moment.at)) continue;
    const bool clock_moves = clock_set_ && moment.at - *clock_set_ < kClockMoves;
    if (clock_moves) continue;  // the times in tickets are shifted in this turn or the next
    const auto served = tickets_.find(session.ticket);
    if (served == tickets_.end()) continue;  // asked and served in one turn
    const double score = MostScore(served->second, moment.at);
    for (const auto& [other_id, known] : tickets_) {
      const auto other = now.tickets.find(other_id);
      if (other == now.tickets.end() || other->second.state != TicketState::kWaiting) continue;
      if (known.last.state != TicketState::kWaiting) continue;
      const Ticket& ticket = other->second;
      if (ticket.rig_class != session.rig_class) continue;
      if (ticket.kind == TicketKind::kPerson && HasSession(now, ticket.user, ticket.rig_class)) {
        continue;
      }
      if (!Fits(now, now.rigs.at(session.rig), ticket, moment.lab)) continue;
      const auto& first = served->second.last.first_expected;
      const auto& other_first = known.last.first_expected;
      const bool kept = KeepsPlace(served->second, moment, kSlack);
      const bool other_kept = KeepsPlace(known, moment, -kSlack);
      if (other_kept && (!kept || *other_first < *first)) {
        Broken("fair order",
               Text(session.ticket) + " overtakes " + Text(other_id) +
                   ", whose first estimate is near");
        continue;
      }
      if (kept || LeastScore(known, moment.at) <= score + Seconds(kSlack)) continue;
      Broken("fair order",
             Text(other_id) + " waits (score from " + std::to_string(LeastScore(known, moment.at)) +
                 "), and " + Text(session.ticket) + " is served (score up to " +
                 std::to_string(score) + ")");
    }
  }
}

void Oracle::JudgeTickets(const Published& now, const Moment& moment) {
  std::map<std::string, std::set<int>> places;
  std::map<std::string, int> waiting;
  std::set<std::pair<UserId, std::string>> people;
  for (const auto& [id, ticket] : now.tickets) {
    const auto [entry, is_new] = tickets_.try_emplace(id);
    if (is_new) {
      entry->second.created = moment.at - (moment.lab - ticket.created);
    }
    entry->second.last = ticket;
    const bool person = ticket.kind == TicketKind::kPerson;
    if (person && !people.insert({ticket.user, ticket.rig_class}).second) {
      Broken("one ticket", Text(id) + " is the second of its user in a class");
    }
    if (ticket.state != TicketState::kWaiting) continue;
    ++waiting[ticket.rig_class];
    places[ticket.rig_class].insert(ticket.place);
    if (person && HasSession(now, ticket.user, ticket.rig_class)) continue;
    for (const auto& [rig_id, rig] : now.rigs) {
      if (rig.rig_class != ticket.rig_class || rig.status != RigStatus::kReady) continue;
      if (!Fits(now, rig, ticket, moment.lab)) continue;
      Broken("nobody waits for a free rig", Text(id) + " waits and fits on " + rig_id);
      break;
    }
  }
  for (const auto& [rig_class, taken] : places) {
    const int count = waiting[rig_class];
    const bool whole =
        static_cast<int>(taken.size()) == count && *taken.begin() == 1 && *taken.rbegin() == count;
    if (!whole) Broken("places", "the places of class " + rig_class + " are not 1 .. n");
  }
  for (auto entry = tickets_.begin(); entry != tickets_.end();) {
    const auto& [id, known] = *entry;
    if (now.tickets.contains(id)) {
      ++entry;
      continue;
    }
    const Ticket& last = known.last;
    const auto end = end_topics_.find(last.offered);
    const bool missed = last.state == TicketState::kOffered && end != end_topics_.end() &&
                        end->second == "offer_missed";
    const bool passed = HasSession(now, last.user, last.rig_class) ||
                        IsDue(now, last.user, last.rig_class, moment.lab);
    const bool left = asked_to_leave_.contains(id);
    if (missed && last.offers_missed == 0 && !left && !passed && !Excused(moment.at)) {
      Broken("offer", Text(id) + " lost its place by one missed offer");
    } else if (!passed && !left && !served_.contains(id) && !Excused(moment.at)) {
      Broken("tickets kept",
             Text(id) + " is gone, which was " + std::string(Name(last.state)) +
                 (last.kind == TicketKind::kJob ? ", of a job" : ""));
    }
    entry = tickets_.erase(entry);
  }
}

void Oracle::Answered(UserId user,
                      const std::string& rig_class,
                      const TicketAnswer& answer,
                      const Published& now) {
  for (const auto& [id, known] : known_) {
    const Session& last = known.last;
    const bool own = last.user == user && last.rig_class == rig_class &&
                     last.kind == TicketKind::kPerson && last.state == SessionState::kActive;
    const auto still = now.sessions.find(id);
    if (!own || still == now.sessions.end() || still->second.user != user) continue;
    const auto* given = std::get_if<Session>(&answer);
    if (given == nullptr || given->id != id) {
      Broken("own session", "a user with a live session did not get it back");
    }
    return;
  }
  for (const auto& [id, known] : tickets_) {
    const bool own = known.last.user == user && known.last.rig_class == rig_class &&
                     known.last.kind == TicketKind::kPerson;
    const auto* given = std::get_if<Ticket>(&answer);
    if (own && now.tickets.contains(id) && given != nullptr && given->id != id) {
      Broken("one ticket", "a user who asked twice has two tickets");
    }
  }
}

}  // namespace faultlab::server::lab::rehearsal
