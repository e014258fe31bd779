// Rules 2, 5 and 8 of the README: bookings on the common timeline, no-shows, moving bookings off
// bad rigs.
#include <algorithm>
#include <tuple>

#include "server/lab/notices.h"
#include "server/lab/opening.h"
#include "server/lab/policy_settings.h"
#include "server/lab/scheduler.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab {
namespace {

using core::Done;

/// An outage of the rig in this time; null if there is none.
const Outage* OutageIn(const LabState& state, const RigId& rig, const Interval& during) {
  for (const auto& [id, outage] : state.outages) {
    if (outage.rig == rig && outage.during.Overlaps(during)) return &outage;
  }
  return nullptr;
}

}  // namespace

/// The check after it belongs to a booking, so that those of an hour follow each other.
WallTime Scheduler::UseEnd(const Booking& booking) const {
  return booking.during.end - (IsElastic(booking.rig_class) ? Milliseconds{0} : policy_.cleaning);
}

core::Status Scheduler::CheckBooking(UserId user,
                                     const std::string& rig_class,
                                     const Interval& during,
                                     WallTime now,
                                     const Courses& courses) const {
  if (!HasClass(state_, rig_class)) return core::Refuse("no_rig_class", "rig_class");
  const PolicySettings& settings = SettingsOf(rig_class);
  if (during.start < now) return core::Refuse("start_past", "start");
  if (during.start > now + settings.booking_ahead) {
    return core::Refuse(
        "booking_too_far", "start", {{"days", settings.booking_ahead / std::chrono::hours(24)}});
  }
  if (during.end <= during.start) return core::Refuse("end_before_start", "end");
  if (during.length() < settings.booking_min) {
    return core::Refuse(
        "booking_too_short", "end", {{"least", settings.booking_min / std::chrono::minutes(1)}});
  }
  if (during.length() > settings.booking_max) {
    return core::Refuse(
        "booking_too_long", "end", {{"most", settings.booking_max / std::chrono::minutes(1)}});
  }
  TRY_DONE(CheckOpen(state_, rig_class, courses, during));
  int live = 0;
  for (const auto& [id, other] : state_.bookings) {
    if (other.user != user || !IsLive(other)) continue;
    ++live;
    if (other.during.Overlaps(during)) {
      return core::Refuse("booking_overlaps", "start");
    }
  }
  if (live >= settings.live_bookings_max) {
    return core::Refuse("bookings_full", "", {{"most", live}});
  }
  return CheckWeek(user, rig_class, during.length(), during.start);
}

core::Result<Booking> Scheduler::Book(UserId user,
                                      const std::string& rig_class,
                                      const Interval& during,
                                      WallTime now,
                                      const Courses& courses,
                                      bool wait) {
  Tick(now);  // who waits for a time is before who books it now
  TRY_DONE(CheckBooking(user, rig_class, during, now, courses));
  Booking booking;
  booking.id = BookingId{state_.next_id};
  booking.user = user;
  booking.rig_class = rig_class;
  booking.during = during;
  booking.courses = courses;
  if (!Plan(booking, now)) {
    const bool late = during.start < now + policy_.given_ahead;
    if (!wait || late) return core::Refuse("no_rig_free_then", "start");
    booking.state = BookingState::kWaiting;
  }
  NewNumber();
  state_.bookings[booking.id] = booking;
  Touch(booking);
  Tick(now);
  const auto stored = state_.bookings.find(booking.id);
  return stored->second;
}

bool Scheduler::Plan(Booking& booking, WallTime now) {
  if (const Rig* rig = FindFreeRig(state_, booking.rig_class, booking.during, now, policy_, "")) {
    booking.rig = rig->id;
    return true;
  }
  const auto plan = PlanAll(state_, booking.rig_class, booking, now, policy_);
  if (!plan) return false;
  booking.rig = plan->at(booking.id);
  for (auto& [id, other] : state_.bookings) {
    const auto moved = plan->find(id);
    if (id == booking.id || moved == plan->end() || moved->second == other.rig) continue;
    other.rig = moved->second;
    Touch(other);
    TellMoved(other, "replanned", "");
  }
  return true;
}

core::Result<std::vector<Booking>> Scheduler::BookAll(UserId user,
                                                      const std::string& rig_class,
                                                      const std::vector<Interval>& times,
                                                      WallTime now,
                                                      const Courses& courses,
                                                      bool wait) {
  if (times.size() == 1) {
    TRY(auto one, Book(user, rig_class, times.front(), now, courses, wait));
    return std::vector<Booking>{std::move(one)};
  }
  Scheduler tried = *this;
  std::vector<BookingId> ids;
  for (const Interval& during : times) {
    const core::Result<Booking> one = tried.Book(user, rig_class, during, now, courses, wait);
    if (one) {
      ids.push_back(one.value().id);
      continue;
    }
    const std::string_view why = one.error().reason;
    if (why == "bookings_full" || why == "no_rig_class") return one.error();
    return core::Refuse("series_refused", "repeat", {{"time", UtcText(during.start)}});
  }
  *this = std::move(tried);
  std::vector<Booking> booked;  // a later one may have moved an earlier one to another rig
  for (const BookingId id : ids) booked.push_back(state_.bookings.at(id));
  return booked;
}

core::Status Scheduler::CancelBooking(BookingId id, std::int64_t version, WallTime now) {
  const auto found = state_.bookings.find(id);
  if (found == state_.bookings.end() || !IsLive(found->second)) {
    return core::Refuse("no_booking");
  }
  Booking& booking = found->second;
  if (booking.version != version) {
    return core::Refuse("booking_changed");
  }
  if (booking.state == BookingState::kClaimed) {
    return core::Refuse("booking_runs");
  }
  if (booking.state == BookingState::kHeld) {
    Close(*FindLive(booking.session), EndReason::kEnded, "cancelled", now);
  } else {
    booking.state = BookingState::kCancelled;
    ++booking.version;
  }
  Touch(booking);
  Tick(now);
  return Done{};
}

core::Result<Session> Scheduler::ClaimBooking(BookingId id, UserId user, WallTime now) {
  const auto found = state_.bookings.find(id);
  if (found == state_.bookings.end() || found->second.user != user || !IsLive(found->second)) {
    return core::Refuse("no_booking");
  }
  Tick(now);
  const auto due = state_.bookings.find(id);
  if (due == state_.bookings.end()) {
    return core::Refuse("no_booking");
  }
  Booking& booking = due->second;
  if (booking.state == BookingState::kWaiting) return core::Refuse("no_rig_free_then");
  if (booking.state == BookingState::kBooked && now < booking.during.start) {
    return core::Refuse("booking_early", "", {{"start", UtcText(booking.during.start)}});
  }
  if (booking.state == BookingState::kBooked) {
    return core::Refuse("rig_not_ready");
  }
  Session* session = FindLive(booking.session);
  if (session == nullptr) return core::Refuse("no_booking");
  if (booking.state == BookingState::kHeld) {
    booking.state = BookingState::kClaimed;
    ++booking.version;
    Activate(*session, now);
    Touch(booking);
  }
  return *session;
}

void Scheduler::Unfulfil(Booking& booking, const std::string& reason, const std::string& why) {
  const std::string text = ReasonText(reason, why);
  booking.state = BookingState::kUnfulfilled;
  booking.note = text;
  ++booking.version;
  Touch(booking);
  Notify({booking.user,
          {},
          "unfulfilled",
          "your booking fell, nothing is charged: " + text,
          booking.rig,
          {},
          why,
          reason,
          booking.during.start});
}

void Scheduler::TellMoved(const Booking& booking,
                          const std::string& reason,
                          const std::string& why) {
  Notify({booking.user,
          {},
          "moved",
          "your booking moved to an equal rig: " + ReasonText(reason, why),
          booking.rig,
          {},
          why,
          reason,
          booking.during.start});
}

/// Moves bookings that start before `horizon` from a rig that will not be available to an equal
/// rig.
void Scheduler::ReplanBookings(const std::string& rig_class, WallTime horizon, WallTime now) {
  for (auto& [id, booking] : state_.bookings) {
    if (booking.state != BookingState::kBooked || booking.rig_class != rig_class) continue;
    if (booking.during.start > horizon || booking.during.end <= now) continue;
    const Interval rest{std::max(booking.during.start, now), booking.during.end};
    const Rig* rig = FindRig(booking.rig);
    const Outage* outage = OutageIn(state_, booking.rig, rest);
    if (rig != nullptr && outage == nullptr && Promising(state_, *rig, now)) continue;
    const std::string reason = rig == nullptr      ? "rig_gone"
                               : outage != nullptr ? "outage"
                                                   : "rig_out";
    const std::string why = rig == nullptr ? "" : outage != nullptr ? outage->reason : rig->reason;
    const Rig* other = FindFreeRig(state_, rig_class, rest, now, policy_, "", id);
    if (other != nullptr) {
      booking.rig = other->id;
      booking.note = "moved: " + ReasonText(reason, why);
      ++booking.version;
      Touch(booking);
      TellMoved(booking, reason, why);
    } else if (booking.during.start <= now) {
      Unfulfil(booking, reason, why);
    }
  }
}

void Scheduler::TickBookings(WallTime now) {
  std::vector<std::string> classes;
  for (const auto& [id, booking] : state_.bookings) {
    if (booking.state == BookingState::kBooked) classes.push_back(booking.rig_class);
  }
  std::sort(classes.begin(), classes.end());
  classes.erase(std::unique(classes.begin(), classes.end()), classes.end());
  for (const auto& rig_class : classes) ReplanBookings(rig_class, now + policy_.heal_ahead, now);

  std::vector<Booking*> due;
  for (auto& [id, booking] : state_.bookings) {
    if (booking.state == BookingState::kBooked && booking.during.start <= now) {
      due.push_back(&booking);
    }
  }
  std::sort(due.begin(), due.end(), [](const Booking* a, const Booking* b) {
    return std::tie(a->during.start, a->id) < std::tie(b->during.start, b->id);
  });
  for (Booking* booking : due) {
    if (UseEnd(*booking) <= now) {
      Unfulfil(*booking, "none_free", "");
      continue;
    }
    Session* own = LiveSessionOf(booking->user, booking->rig_class);
    if (own != nullptr && !EndForBooking(*booking, *own, now)) continue;
    if (Rig* rig = RigForDueBooking(*booking, now)) {
      Session& session =
          Hold(*rig, booking->user, UseEnd(*booking), SettingsOf(booking->rig_class).grace, now);
      session.booking = booking->id;
      session.courses = booking->courses;
      booking->state = BookingState::kHeld;
      booking->rig = rig->id;
      booking->session = session.id;
      ++booking->version;
      Touch(*booking);
      Notify(
          booking->user,
          "due",
          "your rig is ready; claim it within " + LengthText(SettingsOf(booking->rig_class).grace),
          session.id);
    }
  }
  TickWaiting(now);
}

Rig* Scheduler::RigForDueBooking(const Booking& booking, WallTime now) {
  Rig* planned = FindRig(booking.rig);
  if (planned != nullptr && planned->status == RigStatus::kReady) return planned;
  Rig* best = nullptr;
  for (auto& [id, rig] : state_.rigs) {
    if (rig.rig_class != booking.rig_class || rig.status != RigStatus::kReady) continue;
    if (NextCommitment(state_, id, now) < booking.during.end) continue;
    if (best == nullptr || rig.wear < best->wear) best = &rig;
  }
  return best;
}

/// The user already has a session on a rig of the class when the booking begins. The session is
/// prolonged to the booking's end if its rig is free for so long; otherwise it ends, and the
/// booking takes its own rig. An offer that is not accepted yet ends, too.
/// @returns whether the booking needs a rig now
bool Scheduler::EndForBooking(Booking& booking, Session& own, WallTime now) {
  if (own.state == SessionState::kHeld) {
    const bool offer = own.ticket != TicketId{};
    if (offer) Close(own, EndReason::kEnded, "your booking begins", now);
    return offer;  // else an earlier booking of the same user, in its grace
  }
  const WallTime end = std::max(own.hard_end, UseEnd(booking));
  const bool free = NextCommitmentBut(own.rig, own.hard_end, booking.id) >= end + policy_.cleaning;
  if (!free) {
    Close(own, EndReason::kBooking, "your booking begins on another rig", now);
    return true;
  }
  own.hard_end = end;
  own.extended = {};
  own.warning_stage = 0;
  const auto before = state_.bookings.find(own.booking);
  if (before != state_.bookings.end()) {
    before->second.state = BookingState::kDone;
    Touch(before->second);
  }
  own.booking = booking.id;
  own.courses = booking.courses;
  booking.state = BookingState::kClaimed;
  booking.rig = own.rig;
  booking.session = own.id;
  ++booking.version;
  Touch(booking);
  Touch(own);
  return false;
}

WallTime Scheduler::NextCommitmentBut(const RigId& rig, WallTime from, BookingId without) const {
  WallTime next = WallTime::max();
  for (const auto& [id, booking] : state_.bookings) {
    if (id == without || booking.state != BookingState::kBooked || booking.rig != rig) continue;
    next = std::min(next, booking.during.start);
  }
  for (const auto& [id, outage] : state_.outages) {
    if (outage.rig == rig && outage.during.end > from) next = std::min(next, outage.during.start);
  }
  return next;
}

}  // namespace faultlab::server::lab
