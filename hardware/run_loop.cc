#include "hardware/run_loop.h"

#include <pthread.h>
#include <sched.h>

namespace faultlab::hardware {

void RunLoop(Clock& clock, const LoopStep& step) {
  Wake wake;
  while (const std::optional<Nanoseconds> next = step(wake)) wake = clock.SleepUntil(*next);
}

bool AskForFifo(int priority) {
  if (priority == 0) return false;
  const sched_param parameters{.sched_priority = priority};
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

}  // namespace faultlab::hardware
