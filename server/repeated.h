#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "server/clock.h"

namespace faultlab::server {

/// Does something again and again on a thread of its own, until it is destroyed; that waits for the
/// turn in progress.
class Repeated {
 public:
  enum class First { kAtOnce, kAfterAPause };

  /// @param clock  of the pauses; outlives it
  /// @param turn   must not throw
  Repeated(const Clock& clock,
           First first,
           std::chrono::milliseconds pause,
           std::function<void()> turn)
      : clock_(clock),
        turn_(std::move(turn)),
        thread_([this, first, pause] { Loop(first, pause); }) {}
  ~Repeated() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_all();
    thread_.join();
  }
  Repeated(const Repeated&) = delete;
  Repeated& operator=(const Repeated&) = delete;

 private:
  void Loop(First first, std::chrono::milliseconds pause) {
    if (first == First::kAtOnce) turn_();
    std::unique_lock lock(mutex_);
    const auto stopping = [this] { return stopping_; };
    while (!clock_.WaitUntil(lock, wake_, clock_.Monotonic() + pause, stopping)) {
      lock.unlock();
      turn_();
      lock.lock();
    }
  }

  const Clock& clock_;
  const std::function<void()> turn_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::thread thread_;  ///< last: it uses the others
};

}  // namespace faultlab::server
