#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <list>
#include <mutex>
#include <utility>
#include <vector>

#include "server/wall_time.h"

namespace faultlab::server {

using MonotonicTime = std::chrono::steady_clock::time_point;

/// The server's source of time. Passed as an argument, so that tests control the time. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  /// For deadlines and durations: never jumps.
  virtual MonotonicTime Monotonic() const = 0;
  /// For people and for the database: may jump.
  virtual WallTime Wall() const = 0;

  /// Blocks until `done()`, or until it is `until`. `lock` guards what done() reads; whoever
  /// changes that notifies `wake`.
  /// @returns done()
  bool WaitUntil(std::unique_lock<std::mutex>& lock,
                 std::condition_variable& wake,
                 MonotonicTime until,
                 const auto& done) const {
    const auto here = Enter({lock.mutex(), &wake});
    while (!done() && Monotonic() < until) {
      if (passes_) {
        wake.wait_for(lock, until - Monotonic());
      } else {
        wake.wait(lock);
      }
    }
    Leave(here);
    return done();
  }

 protected:
  /// @param passes  by itself; who moves it, whether it passes or not, calls Moved()
  explicit Clock(bool passes = true) : passes_(passes) {}
  /// Those who wait look at the time again. Not while another thread destroys one of them, and not
  /// with the lock of one.
  void Moved() {
    std::vector<Waiter> waiters;
    {
      const std::lock_guard lock(mutex_);
      waiters.assign(waiters_.begin(), waiters_.end());
    }
    for (const auto& [mutex, wake] : waiters) {
      const std::lock_guard lock(*mutex);  // it waits, or will see the new time
      wake->notify_all();
    }
  }

 private:
  using Waiter = std::pair<std::mutex*, std::condition_variable*>;
  std::list<Waiter>::iterator Enter(const Waiter& waiter) const {
    const std::lock_guard lock(mutex_);
    return waiters_.insert(waiters_.end(), waiter);
  }
  void Leave(std::list<Waiter>::iterator waiter) const {
    const std::lock_guard lock(mutex_);
    waiters_.erase(waiter);
  }

  const bool passes_;
  mutable std::mutex mutex_;
  mutable std::list<Waiter> waiters_;
};

class SystemClock : public Clock {
 public:
  MonotonicTime Monotonic() const override { return std::chrono::steady_clock::now(); }
  WallTime Wall() const override {
    return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  }
};

/// Of this machine.
inline const SystemClock kSystemClock;

/// Stands still until a test moves it.
class ManualClock : public Clock {
 public:
  /// Starts at 2026-01-01T00:00:00Z.
  ManualClock() : Clock(/*passes=*/false) {}

  MonotonicTime Monotonic() const override {
    return MonotonicTime(std::chrono::nanoseconds(monotonic_ns_.load()));
  }
  WallTime Wall() const override {
    return WallTime(std::chrono::milliseconds(wall_ns_.load() / 1'000'000));
  }

  void Advance(std::chrono::nanoseconds step) {
    monotonic_ns_ += step.count();
    wall_ns_ += step.count();
    Moved();
  }
  /// An administrator or NTP sets the clock: wall time jumps, monotonic time continues.
  void JumpWall(std::chrono::nanoseconds step) { wall_ns_ += step.count(); }

 private:
  std::atomic<std::int64_t> monotonic_ns_{1'000'000'000};
  std::atomic<std::int64_t> wall_ns_{1'767'225'600'000'000'000};
};

}  // namespace faultlab::server
