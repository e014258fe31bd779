#include "server/lab/timeline.h"

#include <algorithm>
#include <tuple>

#include "core/types/check.h"

namespace faultlab::server::lab {
namespace {

constexpr Milliseconds kStartGrid{std::chrono::minutes(5)};
constexpr std::size_t kSlotsMax = 2000;

bool IsFree(std::span<const Interval> busy, const Interval& during) {
  return std::ranges::none_of(busy, [&](const Interval& b) { return b.Overlaps(during); });
}

WallTime OnGrid(WallTime time) {
  const auto beyond = time.time_since_epoch() % kStartGrid;
  return beyond == Milliseconds{0} ? time : time + (kStartGrid - beyond);
}

using BusyByRig = std::map<RigId, std::vector<Interval>>;

/// Only sessions, cleaning and outages, which a new plan cannot move.
BusyByRig FixedBusy(const LabState& state,
                    const std::string& rig_class,
                    WallTime now,
                    const Policy& policy,
                    bool with_bookings) {
  BusyByRig busy;
  for (const auto& [id, rig] : state.rigs) {
    if (rig.rig_class != rig_class || !Promising(state, rig, now)) continue;
    busy[id];
    // The check as long as it takes, not as long as it may: a booking waits for it where it begins.
    if (rig.status == RigStatus::kCleaning) {
      busy[id].push_back({now, std::min(rig.cleaning_due, now + policy.cleaning)});
    }
  }
  const auto add = [&](const RigId& rig, const Interval& during) {
    const auto found = busy.find(rig);
    if (found != busy.end()) found->second.push_back(during);
  };
  for (const auto& [id, session] : state.sessions) {
    if (session.state == SessionState::kClosed) continue;
    add(session.rig, {session.start, std::max(session.hard_end, now) + policy.cleaning});
  }
  for (const auto& [id, outage] : state.outages) add(outage.rig, outage.during);
  if (with_bookings) {
    for (const auto& [id, booking] : state.bookings) {
      if (booking.state != BookingState::kBooked) continue;
      add(booking.rig, booking.during);
    }
  }
  return busy;
}

}  // namespace

bool HasClass(const LabState& state, const std::string& rig_class) {
  return std::ranges::any_of(
      state.rigs, [&](const auto& entry) { return entry.second.rig_class == rig_class; });
}

std::vector<Interval> BusyIntervals(const LabState& state,
                                    const RigId& rig,
                                    const Policy& policy,
                                    std::optional<BookingId> without) {
  std::vector<Interval> busy;
  const auto found = state.rigs.find(rig);
  if (found != state.rigs.end() && found->second.status == RigStatus::kCleaning) {
    const WallTime due = found->second.cleaning_due;
    busy.push_back({due - policy.cleaning_max, due});
  }
  for (const auto& [id, session] : state.sessions) {
    if (session.state == SessionState::kClosed || session.rig != rig) continue;
    busy.push_back({session.start, session.hard_end + policy.cleaning});
  }
  for (const auto& [id, booking] : state.bookings) {
    if (booking.state != BookingState::kBooked || booking.rig != rig || without == id) continue;
    busy.push_back(booking.during);
  }
  for (const auto& [id, outage] : state.outages) {
    if (outage.rig == rig) busy.push_back(outage.during);
  }
  std::ranges::sort(busy);
  return busy;
}

bool Promising(const LabState& state, const Rig& rig, WallTime now) {
  switch (rig.status) {
    case RigStatus::kReady:
    case RigStatus::kLeased:
    case RigStatus::kCleaning:
      return true;
    case RigStatus::kMaintenance:
      return std::ranges::any_of(state.outages, [&](const auto& entry) {
        const Outage& outage = entry.second;
        return outage.rig == rig.id && outage.during.start <= now && now < outage.during.end;
      });
    case RigStatus::kOffline:
    case RigStatus::kQuarantined:
      return false;
  }
  return false;
}

WallTime NextCommitment(const LabState& state, const RigId& rig, WallTime from) {
  WallTime next = WallTime::max();
  for (const auto& [id, booking] : state.bookings) {
    if (booking.state != BookingState::kBooked || booking.rig != rig) continue;
    // A booking whose start has passed without a rig still needs this one: nothing fits before it.
    next = std::min(next, std::max(booking.during.start, from));
  }
  for (const auto& [id, outage] : state.outages) {
    if (outage.rig != rig || outage.during.end <= from) continue;
    next = std::min(next, std::max(outage.during.start, from));
  }
  return next;
}

bool IsFreeForPractice(const LabState& state, const RigId& id, Milliseconds length, WallTime now) {
  const auto rig = state.rigs.find(id);
  return rig != state.rigs.end() && rig->second.elastic &&
         rig->second.status == RigStatus::kReady && NextCommitment(state, id, now) >= now + length;
}

const Rig* FindFreeRig(const LabState& state,
                       const std::string& rig_class,
                       const Interval& during,
                       WallTime now,
                       const Policy& policy,
                       const RigId& preferred,
                       std::optional<BookingId> without) {
  const Rig* best = nullptr;
  const auto rank = [&](const Rig& rig) {
    return std::make_tuple(rig.id != preferred, rig.wear, rig.id);
  };
  for (const auto& [id, rig] : state.rigs) {
    if (rig.rig_class != rig_class || !Promising(state, rig, now)) continue;
    if (best != nullptr && rank(*best) < rank(rig)) continue;
    if (IsFree(BusyIntervals(state, id, policy, without), during)) best = &rig;
  }
  return best;
}

std::optional<std::map<BookingId, RigId>> PlanAll(const LabState& state,
                                                  const std::string& rig_class,
                                                  const std::optional<Booking>& extra,
                                                  WallTime now,
                                                  const Policy& policy) {
  BusyByRig busy = FixedBusy(state, rig_class, now, policy, /*with_bookings=*/false);
  std::vector<const Booking*> bookings;
  for (const auto& [id, booking] : state.bookings) {
    if (booking.state == BookingState::kBooked && booking.rig_class == rig_class) {
      bookings.push_back(&booking);
    }
  }
  if (extra) bookings.push_back(&*extra);
  std::ranges::sort(bookings, [](const Booking* a, const Booking* b) {
    return std::tie(a->during.start, a->id) < std::tie(b->during.start, b->id);
  });
  std::map<BookingId, RigId> plan;
  for (const Booking* booking : bookings) {
    const Interval& wanted = booking->during;
    const RigId* chosen = nullptr;
    for (const auto& [id, intervals] : busy) {
      if (!IsFree(intervals, wanted)) continue;
      if (chosen == nullptr || id == booking->rig) chosen = &id;
    }
    if (chosen == nullptr) return std::nullopt;
    plan[booking->id] = *chosen;
    busy[*chosen].push_back(wanted);
  }
  return plan;
}

std::vector<Slot> Availability(const LabState& state,
                               const std::string& rig_class,
                               const Interval& range,
                               Milliseconds step,
                               Milliseconds length,
                               WallTime now,
                               const Policy& policy,
                               std::span<const Interval> taken) {
  LAB_CHECK(step > Milliseconds{0}, step.count());
  const BusyByRig busy = FixedBusy(state, rig_class, now, policy, /*with_bookings=*/true);
  std::vector<Slot> slots;
  for (WallTime start = range.start; start < range.end && slots.size() < kSlotsMax; start += step) {
    Slot slot{{start, start + length}, 0};
    const bool may = start >= now && IsFree(taken, slot.during);
    for (const auto& [id, intervals] : busy) {
      if (may && IsFree(intervals, slot.during)) ++slot.free;
    }
    slots.push_back(slot);
  }
  return slots;
}

std::vector<WallTime> NextFree(const LabState& state,
                               const std::string& rig_class,
                               const Interval& range,
                               Milliseconds length,
                               int count,
                               WallTime now,
                               const Policy& policy,
                               std::span<const Interval> taken) {
  const BusyByRig busy = FixedBusy(state, rig_class, now, policy, /*with_bookings=*/true);
  // A free interval begins where one looks, or where something ends; no other start is earlier.
  std::vector<WallTime> candidates;
  for (const auto& [id, intervals] : busy) {
    for (const auto& interval : intervals) candidates.push_back(OnGrid(interval.end));
  }
  for (const Interval& own : taken) candidates.push_back(OnGrid(own.end));
  std::ranges::sort(candidates);
  const auto fits = [&](WallTime start) {
    const Interval slot{start, start + length};
    return IsFree(taken, slot) &&
           std::ranges::any_of(busy, [&](const auto& entry) { return IsFree(entry.second, slot); });
  };
  const auto first_from = [&](WallTime from) {
    if (fits(from)) return from;
    const auto later = std::upper_bound(candidates.begin(), candidates.end(), from);
    const auto found = std::find_if(later, candidates.end(), fits);
    return found == candidates.end() ? WallTime::max() : *found;
  };
  std::vector<WallTime> starts;
  WallTime from = OnGrid(std::max(range.start, now));
  Milliseconds distance = std::max(length, kStartGrid);
  while (static_cast<int>(starts.size()) < count) {
    const WallTime start = first_from(from);
    if (start == WallTime::max() || start + length > range.end) break;
    starts.push_back(start);
    from = OnGrid(start + distance);
    distance *= 2;
  }
  return starts;
}

}  // namespace faultlab::server::lab
