#pragma once

#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/lab/lab_types.h"

// When a class of rigs is open. A class without opening hours (windows for everybody) always is;
// one that has some is open in them alone. In a window of a course its people alone have the class,
// also outside the opening hours. What begins in an open time ends in it, with its check. Hours
// that are over go; of opening hours the last stay, so that a class does not open by itself.
namespace faultlab::server::lab {

/// Who waits for a class that opens later is not told a time yet.
inline constexpr Milliseconds kExpectedWithin = std::chrono::hours(24 * 14);

/// A time in which a person cannot be on a rig of the class.
struct Shut {
  Interval during;
  const Window* of = nullptr;  ///< the course's, of the state; null: closed
};

/// All that meet `range`, for somebody of these courses. Those of courses come first, whole; closed
/// times are cut to the range. Both may overlap.
std::vector<Shut> ShutTimes(const LabState& state,
                            const std::string& rig_class,
                            const Courses& courses,
                            const Interval& range);

/// When the class is shut for them next, from `from` on; WallTime::max() when not for as long as
/// any session can last.
WallTime NextShut(const LabState& state,
                  const std::string& rig_class,
                  const Courses& courses,
                  WallTime from);

/// When it is open for them next; WallTime::max() when not within `range`.
WallTime NextOpen(const LabState& state,
                  const std::string& rig_class,
                  const Courses& courses,
                  const Interval& range);

/// Refuses a time that is shut for them, for the reason.
core::Status CheckOpen(const LabState& state,
                       const std::string& rig_class,
                       const Courses& courses,
                       const Interval& during);

}  // namespace faultlab::server::lab
