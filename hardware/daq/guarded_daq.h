#pragma once

#include <memory>

#include "hardware/clock.h"
#include "hardware/daq/daq.h"

namespace faultlab::hardware {

struct GuardedDaqOptions {
  /// A driver call that has not returned by then is given up; time in which this process stood
  /// still does not count (patience.h). Well above what a healthy driver needs, well below what a
  /// motor may suffer.
  Nanoseconds patience = std::chrono::milliseconds(250);
  double drive_zero_v = 0.0;  ///< terminal volt of drive 0
  int fifo_priority = 0;      ///< of the thread that calls the driver; 0 = ordinary
};

/// A Daq whose calls come back: the driver is called on a thread of its own, and a call that hangs
/// throws DriverHang instead of holding its caller for ever. Until the driver has returned, every
/// further call throws DriverHang at once. A call that returns after it was given up may have put
/// anything out: drive 0 follows it at once, before anything else is done.
///
/// What cannot be done from here: while the driver hangs, the board keeps what it put out last.
/// Destruction does not wait for a hung call either; the driver is then left to the process's end.
std::unique_ptr<Daq> MakeGuardedDaq(std::unique_ptr<Daq> driver, GuardedDaqOptions options);

}  // namespace faultlab::hardware
