#pragma once

#include <algorithm>

#include "hardware/clock.h"

namespace faultlab::hardware {

/// How long a driver may take, in time in which this process ran. A process that stood still (a
/// paused virtual machine, SIGSTOP, a core taken away) wakes to find the clock far ahead, although
/// the driver had no time either. Therefore one waits in slices, and a slice counts at most twice
/// its length.
///
///   Patience patience(limit);
///   while (!done && !patience.over()) { wait(patience.slice()); patience.Waited(measured); }
class Patience {
 public:
  static constexpr Nanoseconds kSlice = std::chrono::milliseconds(25);

  explicit Patience(Nanoseconds limit) : left_(limit) {}

  bool over() const { return left_ <= Nanoseconds(0); }
  Nanoseconds slice() const { return std::min(kSlice, left_); }
  void Waited(Nanoseconds measured) { left_ -= std::min(measured, 2 * slice()); }

 private:
  Nanoseconds left_;
};

}  // namespace faultlab::hardware
