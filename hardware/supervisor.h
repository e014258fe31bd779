#pragma once

#include <chrono>
#include <functional>

#include "hardware/heartbeat.h"

namespace faultlab::hardware {

/// Runs `work` in a child process and waits: the second line behind the safe stops of the child.
///
///   child dies by a signal (SIGKILL, a crash)   -> make_safe, up to three times
///   child drives and falls silent (SIGSTOP,     -> killed, so that it cannot go on and lets go of
///     a deadlock, a debugger)                      the board; make_safe
///   child calls for help (a driver that hangs)  -> make_safe beside it; if that fails, the child
///                                                  is killed, and make_safe tries once more
///
/// Silence counts only while the child drives (heartbeat.h): one that starts, tests itself or is
/// idle has drive 0, and nobody is helped by its death. silence_max of it is no slow tick any more,
/// whatever the reason: a machine too busy to run the loop does not control the motor either.
/// When this process itself could not look in time (stopped with the child, a suspended or
/// overloaded machine), the child gets another silence_max to speak.
/// A child that does not die at once hangs in the kernel: make_safe runs beside it.
///
/// `make_safe` runs in a process of its own and is killed after `patience`: the driver that hung
/// in the child may hang there too. It returns true when the bench is safe.
/// SIGTERM and SIGINT go on to the child; when this process dies, the child gets SIGTERM.
/// Neither line helps when both die or stand still at once, the machine does, or no process reaches
/// the board: then only the board's own watchdog or the bench's emergency stop can.
/// @returns the child's exit status; 1 after its death by a signal: who started this one starts it
///          again.
/// Call before any thread is started.
struct SupervisorOptions {
  std::chrono::milliseconds patience{5000};
  /// Of a child that drives, beyond the tick that it announced. As it is on a rig; longer where a
  /// child must live although the machine is taken away from it.
  Nanoseconds silence_max = kSilenceMax;
  /// SCHED_FIFO for this process and make_safe, so that a busy machine does not delay them; 0 or no
  /// right to it: ordinary.
  int fifo_priority = 0;
  std::function<void(const char* text)> say;  ///< for the log; may be empty
};
/// @param work  gets the way to tell this process its words
int Supervise(const std::function<int(const SendWord& send)>& work,
              const std::function<bool()>& make_safe,
              const SupervisorOptions& options = {});

}  // namespace faultlab::hardware
