#include "hardware/run_loop.h"

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>

namespace faultlab::hardware {
namespace {

/// struct sched_attr of the kernel, whose header collides with <sched.h>.
struct SchedulingAttributes {
  std::uint32_t size = 0;
  std::uint32_t policy = 0;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t slice_ns = 0;
  std::uint64_t deadline_ns = 0;
  std::uint64_t period_ns = 0;
};

}  // namespace

void RunLoop(Clock& clock, const LoopStep& step) {
  Wake wake;
  while (const std::optional<Nanoseconds> next = step(wake)) wake = clock.SleepUntil(*next);
}

bool AskForFifo(int priority) {
  if (priority == 0) return false;
  const sched_param parameters{.sched_priority = priority};
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

void AskForShortSlices() {
  constexpr pid_t kThisThread = 0;
  constexpr unsigned kNoFlags = 0;
  SchedulingAttributes wanted{};
  wanted.size = sizeof(wanted);
  wanted.policy = SCHED_OTHER;
  wanted.nice = getpriority(PRIO_PROCESS, kThisThread);
  wanted.slice_ns = 100'000;  // the least that there is
  (void)syscall(SYS_sched_setattr, kThisThread, &wanted, kNoFlags);
}

}  // namespace faultlab::hardware
