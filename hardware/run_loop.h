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

/// Asks the scheduler to look at the calling thread often: one that wakes for a few microseconds
/// does not wait until another has used up its slice of milliseconds. Linux 6.12; older ones let it
/// pass by themselves, or do not know the question.
void AskForShortSlices();

}  // namespace faultlab::hardware
