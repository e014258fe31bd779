#include "hardware/run_loop.h"

#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <thread>

namespace faultlab::hardware {
namespace {

class ThreadRunner final : public LoopRunner {
 public:
  explicit ThreadRunner(int fifo_priority) : fifo_priority_(fifo_priority) {}

  std::unique_ptr<Handle> Launch(LoopTask& task) override {
    return std::make_unique<ThreadHandle>(*this, task);
  }

  bool fifo() const override { return fifo_; }

 private:
  class ThreadHandle final : public Handle {
   public:
    ThreadHandle(ThreadRunner& runner, LoopTask& task)
        : thread_([fifo = runner.fifo_flag(), priority = runner.fifo_priority_, &task] {
            if (priority > 0) {
              const sched_param parameters{.sched_priority = priority};
              *fifo = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
            }
            Wake wake;
            while (const std::optional<Nanoseconds> next = task.Step(wake)) {
              wake = task.clock().SleepUntil(*next);
            }
          }) {}
    ~ThreadHandle() override { thread_.join(); }

   private:
    std::thread thread_;
  };

  std::atomic<bool>* fifo_flag() { return &fifo_; }

  const int fifo_priority_;
  std::atomic<bool> fifo_{false};
};

}  // namespace

std::shared_ptr<LoopRunner> MakeThreadRunner(int fifo_priority) {
  return std::make_shared<ThreadRunner>(fifo_priority);
}

}  // namespace faultlab::hardware
