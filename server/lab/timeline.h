#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

bool HasClass(const LabState& state, const std::string& rig_class);

/// Everything that occupies one rig from `now` on, cleaning included, ordered by start: live
/// session, running cleaning, bookings planned on it, outages. Claimed and held bookings count as
/// sessions.
std::vector<Interval> BusyIntervals(const LabState& state,
                                    const RigId& rig,
                                    const Policy& policy,
                                    std::optional<BookingId> without = std::nullopt);

/// Whether the rig works now, or will work without repair: ready, leased, in cleaning, or in a
/// planned outage that ends.
bool Promising(const LabState& state, const Rig& rig, WallTime now);

/// The start of the first booking or planned outage on the rig at or after `from`; WallTime::max()
/// when there is none.
WallTime NextCommitment(const LabState& state, const RigId& rig, WallTime from);

/// Whether practice of this length may begin on the rig now: it is a ready simulator, and nothing
/// is planned on it until then.
bool IsFreeForPractice(const LabState& state, const RigId& rig, Milliseconds length, WallTime now);

/// The rig of the class that is free for the whole booking, or nullptr.
/// Prefers `preferred`, then the least used, then the lowest id.
const Rig* FindFreeRig(const LabState& state,
                       const std::string& rig_class,
                       const Interval& during,
                       WallTime now,
                       const Policy& policy,
                       const RigId& preferred,
                       std::optional<BookingId> without = std::nullopt);

/// Plans every kBooked booking of a class anew, and one more if given, each on one rig for its
/// whole time. nullopt when greedy placing by start does not find room for all.
std::optional<std::map<BookingId, RigId>> PlanAll(const LabState& state,
                                                  const std::string& rig_class,
                                                  const std::optional<Booking>& extra,
                                                  WallTime now,
                                                  const Policy& policy);

/// On how many rigs of the class a booking could have this time, for a week grid.
struct Slot {
  Interval during;
  int free = 0;
};
/// Slots of `length` that start every `step` from `from` to `to`; at most 2000. What is free here
/// can be booked by whoever has nothing else then.
/// @param taken  when this person cannot: their own bookings, on whatever rig
std::vector<Slot> Availability(const LabState& state,
                               const std::string& rig_class,
                               const Interval& range,
                               Milliseconds step,
                               Milliseconds length,
                               WallTime now,
                               const Policy& policy,
                               std::span<const Interval> taken = {});

/// Up to `count` starts, each on a whole 5 min, at which a booking of `length` fits within `range`:
/// the first, then further and further from it. The second is one length later at least, and each
/// distance is at least twice the one before, so that a few starts reach over hours and days.
std::vector<WallTime> NextFree(const LabState& state,
                               const std::string& rig_class,
                               const Interval& range,
                               Milliseconds length,
                               int count,
                               WallTime now,
                               const Policy& policy,
                               std::span<const Interval> taken = {});

}  // namespace faultlab::server::lab
