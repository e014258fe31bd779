#pragma once

#include <cstdint>

namespace faultlab::hardware {

/// How the analog inputs of a stand-in clock their conversions.
enum class StandInScans {
  kNone,          ///< single reads only
  kAtOnce,        ///< the first scan begins with the command
  kAfterAPeriod,  ///< the first scan begins a period after the command, in real time
};

/// Gives a test access to a stand-in driver (a shared library, loaded by the code under test): each
/// exports `StandInControl* stand_in_control()`.
struct StandInControl {
  std::int64_t now_ns = 0;  ///< time of its plant; std::atomic_ref where threads are
  std::uint64_t seed = 1;
  int calls = 0;          ///< driver calls since the last reset
  int fail_at = -1;       ///< this call returns an error
  int open_handles = 0;   ///< tasks or devices not released
  int misuses = 0;        ///< calls in a wrong order or with impossible arguments
  char misuse[256] = {};  ///< the first of them
  double drive_v = 0.0;
  std::uint32_t relay_levels = 0xffffffffu;
  int watchdog_fed = 0;     ///< times the board's own watchdog was reset
  double watchdog_s = 0.0;  ///< its time, while one is armed
  bool begin_run = false;   ///< set: the plant starts anew at the next call
  bool swapped = false;     ///< the encoder's channels: what turns forwards counts backwards
  StandInScans scans = StandInScans::kNone;
  bool scans_silent = false;  ///< commands are taken, and no value comes
  int scans_say_end = 0;      ///< so often a read says that a scan has ended, before its values
  int commands = 0;           ///< taken
  int cancels = 0;            ///< of commands that were still going on
};

using StandInControlFunction = StandInControl*();

}  // namespace faultlab::hardware
