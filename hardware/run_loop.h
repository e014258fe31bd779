#pragma once

#include <memory>
#include <optional>

#include "hardware/clock.h"

namespace faultlab::hardware {

/// What a paced loop runs: steps at absolute deadlines.
class LoopTask {
 public:
  virtual ~LoopTask() = default;
  virtual Clock& clock() = 0;
  /// Does what is due. @returns the next deadline on clock(), or nothing when the task is over.
  virtual std::optional<Nanoseconds> Step(const Wake& wake) noexcept = 0;
};

/// Where loops run: a thread each.
class LoopRunner {
 public:
  /// Destruction waits for the end of the task.
  class Handle {
   public:
    virtual ~Handle() = default;
  };

  virtual ~LoopRunner() = default;
  /// Steps `task` until it is over. The task must outlive the handle.
  virtual std::unique_ptr<Handle> Launch(LoopTask& task) = 0;
  /// True when loops of this runner got the priority asked for.
  virtual bool fifo() const = 0;
};

/// One thread per loop. `fifo_priority` > 0 asks for SCHED_FIFO; without the right to it the loop
/// runs as an ordinary thread and fifo() says so.
std::shared_ptr<LoopRunner> MakeThreadRunner(int fifo_priority);

}  // namespace faultlab::hardware
