#pragma once

#include <chrono>
#include <functional>

namespace faultlab::hardware {

/// Runs `work` in a child process and waits: the second line behind the safe stops of the child.
///
///   child dies by a signal (SIGKILL, a crash)   -> make_safe
///   child calls for help (a driver that hangs)  -> make_safe beside it; if that fails, the child
///                                                  is killed, so that it lets go of the board, and
///                                                  make_safe tries once more
///
/// `make_safe` runs in a process of its own and is killed after `patience`: the driver that hung
/// in the child may hang there too. It returns true when the bench is safe.
/// SIGTERM and SIGINT go on to the child; when this process dies, the child gets SIGTERM.
/// Neither line helps when both die at once, the machine does, or no process reaches the board:
/// then only the board's own watchdog or the bench's emergency stop can.
/// @returns the child's exit status; 1 after its death by a signal.
/// Call before any thread is started.
struct SupervisorOptions {
  std::chrono::milliseconds patience{5000};
  std::function<void(const char* text)> say;  ///< for the log; may be empty
};
/// @param work  gets the call for help, which may be made from any thread, any number of times
int Supervise(const std::function<int(const std::function<void()>& call_for_help)>& work,
              const std::function<bool()>& make_safe,
              const SupervisorOptions& options = {});

}  // namespace faultlab::hardware
