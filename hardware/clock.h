#pragma once

#include <chrono>
#include <memory>

namespace faultlab::hardware {

/// Time of a rig, nanoseconds from an arbitrary start, never going back.
using Nanoseconds = std::chrono::nanoseconds;

/// What a sleeper finds when it wakes.
struct Wake {
  Nanoseconds lateness{0};       ///< on the clock's own time; a simulated clock is never late
  Nanoseconds wall_lateness{0};  ///< what the machine made of it
};

/// The seam between a rig and time. A clock serves one loop: Now from any thread, SleepUntil from
/// the loop's alone.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual Nanoseconds Now() const = 0;
  /// Returns when Now() >= deadline, at once if it already is.
  virtual Wake SleepUntil(Nanoseconds deadline) = 0;
};

/// CLOCK_MONOTONIC with clock_nanosleep(TIMER_ABSTIME).
std::shared_ptr<Clock> MakeSteadyClock();

/// The same for a loop that follows a device: it is never late, since it keeps no time.
std::shared_ptr<Clock> MakeFollowingClock();

/// Time of a simulator: Now() is exactly the deadline last slept for, so that a run gives the same
/// numbers however busy the machine is. Real time passes `speed` times slower.
///   speed 1: real time.  2: twice as fast.  0: never sleeps.
/// Deadlines closer than `grain` to the last real sleep pass without one: the two halves of a tick
/// cost one wake-up.
std::shared_ptr<Clock> MakeSimulatedClock(double speed, Nanoseconds grain);

}  // namespace faultlab::hardware
