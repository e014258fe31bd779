// Rule 14 of the README: who waits for a time that others have.
#include <algorithm>
#include <functional>
#include <set>
#include <tuple>

#include "server/lab/opening.h"
#include "server/lab/scheduler.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab {

/// What room for bookings depends on: it becomes more only where this changes.
std::size_t Scheduler::RoomMark(WallTime now) const {
  std::size_t mark = 0;
  const auto add = [&](auto value) {
    mark = mark * 1'000'003 + std::hash<decltype(value)>{}(value);
  };
  for (const auto& [id, rig] : state_.rigs) add(Promising(state_, rig, now));
  for (const auto& [id, outage] : state_.outages) add(Number(id));
  for (const auto& [id, window] : state_.windows) add(Number(id));
  for (const auto& [id, booking] : state_.bookings) {
    add(Number(id) * 8 + static_cast<std::int64_t>(booking.state));
    add(booking.rig);
  }
  for (const auto& [id, session] : state_.sessions) {
    add(Number(id) * 4 + static_cast<std::int64_t>(session.state));
    add(ToMilliseconds(session.hard_end));
  }
  return mark;
}

/// Rigs that are free then, but for those that a promised booking needs, whose own rig is out.
bool Scheduler::GiveTime(Booking& booking, WallTime now) {
  std::ptrdiff_t free = 0;
  for (const auto& [id, rig] : state_.rigs) {
    if (rig.rig_class != booking.rig_class || !Promising(state_, rig, now)) continue;
    const std::vector<Interval> busy = BusyIntervals(state_, id, policy_);
    free += std::ranges::none_of(
        busy, [&](const Interval& each) { return each.Overlaps(booking.during); });
  }
  const auto stranded = std::ranges::count_if(state_.bookings, [&](const auto& each) {
    const Booking& other = each.second;
    const Rig* const rig = FindRig(other.rig);
    return other.state == BookingState::kBooked && other.rig_class == booking.rig_class &&
           other.during.Overlaps(booking.during) &&
           (rig == nullptr || !Promising(state_, *rig, now));
  });
  return (stranded == 0 || free > stranded) && Plan(booking, now);
}

/// Who asked first is first.
void Scheduler::TickWaiting(WallTime now) {
  const auto waits = [](const auto& each) { return each.second.state == BookingState::kWaiting; };
  if (std::ranges::none_of(state_.bookings, waits)) return;
  const std::size_t mark = RoomMark(now);
  const bool changed = room_tried_ != mark;
  std::set<std::tuple<std::string, Interval, Courses>> in_vain;
  for (auto& [id, booking] : state_.bookings) {
    if (booking.state != BookingState::kWaiting) continue;
    const bool over = booking.during.start < now + policy_.given_ahead;
    if (!over && !changed) continue;
    const auto open = [&, &booking = booking] {
      return CheckOpen(state_, booking.rig_class, booking.courses, booking.during).ok();
    };
    if (!over) {
      const std::tuple wanted(booking.rig_class, booking.during, booking.courses);
      const bool may =
          CheckWeek(booking.user, booking.rig_class, booking.during.length(), booking.during.start)
              .ok();
      if (!may || in_vain.contains(wanted)) continue;
      if (!open() || !GiveTime(booking, now)) {
        in_vain.insert(wanted);
        continue;
      }
    }
    booking.state = over ? BookingState::kCancelled : BookingState::kBooked;
    ++booking.version;
    Touch(booking);
    Notify({booking.user,
            {},
            over ? "time_not_free" : "time_free",
            over ? "nobody gave back the time that you waited for"
                 : "the time that you waited for is yours: a rig has become free",
            booking.rig,
            {},
            "",
            over && !open() ? "hours" : "",
            booking.during.start});
  }
  room_tried_ = RoomMark(now);
}

}  // namespace faultlab::server::lab
