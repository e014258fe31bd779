#pragma once

#include <functional>

namespace faultlab::hardware {

/// Runs `work` in a child process and waits. When the child dies by a signal (SIGKILL, a crash),
/// `make_safe` runs here: the second line behind the safe stops of the child itself. SIGTERM and
/// SIGINT go on to the child; when this process dies, the child gets SIGTERM.
/// Neither helps when both die at once or the machine does: then only the board's own watchdog or
/// the bench's emergency stop can.
/// @returns the child's exit status, or 1 after a death by signal (when make_safe has run).
/// Call before any thread is started.
int Supervise(const std::function<int()>& work, const std::function<void()>& make_safe);

}  // namespace faultlab::hardware
