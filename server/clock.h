#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

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
  ManualClock() = default;

  MonotonicTime Monotonic() const override {
    return MonotonicTime(std::chrono::nanoseconds(monotonic_ns_.load()));
  }
  WallTime Wall() const override {
    return WallTime(std::chrono::milliseconds(wall_ns_.load() / 1'000'000));
  }

  void Advance(std::chrono::nanoseconds step) {
    monotonic_ns_ += step.count();
    wall_ns_ += step.count();
  }
  /// An administrator or NTP sets the clock: wall time jumps, monotonic time continues.
  void JumpWall(std::chrono::nanoseconds step) { wall_ns_ += step.count(); }

 private:
  std::atomic<std::int64_t> monotonic_ns_{1'000'000'000};
  std::atomic<std::int64_t> wall_ns_{1'767'225'600'000'000'000};
};

}  // namespace faultlab::server
