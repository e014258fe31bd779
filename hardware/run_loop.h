#pragma once

#include <functional>
#include <optional>

#include "hardware/clock.h"

namespace faultlab::hardware {

/// Does what is due. @returns the next deadline, or nothing when the loop is over.
using LoopStep = std::function<std::optional<Nanoseconds>(const Wake& wake)>;

/// Calls `step` at once, then at each deadline on `clock` that it returned, until the loop is over.
void RunLoop(Clock& clock, const LoopStep& step);

/// Asks for SCHED_FIFO for the calling thread. @returns false when it stays an ordinary one: for
/// priority 0, and without the right to it.
bool AskForFifo(int priority);

}  // namespace faultlab::hardware
