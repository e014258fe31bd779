#include "hardware/clock.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <ctime>

#include "core/types/check.h"

namespace faultlab::hardware {
namespace {

Nanoseconds MonotonicNow() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::chrono::seconds(now.tv_sec) + Nanoseconds(now.tv_nsec);
}

/// @returns how late the sleeper woke.
Nanoseconds MonotonicSleepUntil(Nanoseconds deadline) {
  if (MonotonicNow() < deadline) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(deadline);
    const timespec until{.tv_sec = seconds.count(), .tv_nsec = (deadline - seconds).count()};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
  }
  return std::max(MonotonicNow() - deadline, Nanoseconds(0));
}

class SteadyClock final : public Clock {
 public:
  Nanoseconds Now() const override { return MonotonicNow(); }
  Wake SleepUntil(Nanoseconds deadline) override {
    const Nanoseconds lateness = MonotonicSleepUntil(deadline);
    return {.lateness = lateness, .wall_lateness = lateness};
  }
};

class FollowingClock final : public Clock {
 public:
  Nanoseconds Now() const override { return MonotonicNow(); }
  Wake SleepUntil(Nanoseconds deadline) override {
    return {.wall_lateness = MonotonicSleepUntil(deadline)};
  }
};

class SimulatedClock final : public Clock {
 public:
  SimulatedClock(double speed, Nanoseconds grain) : speed_(speed), grain_(grain) {}

  Nanoseconds Now() const override { return Nanoseconds(now_.load(std::memory_order_relaxed)); }

  Wake SleepUntil(Nanoseconds deadline) override {
    if (deadline.count() > now_.load(std::memory_order_relaxed)) {
      now_.store(deadline.count(), std::memory_order_relaxed);
    }
    if (speed_ <= 0.0 || (anchored_ && deadline - last_slept_ < grain_)) return {};
    // The first sleep anchors simulated to real time; a long pause (no run) anchors anew.
    const Nanoseconds wall = MonotonicNow();
    if (!anchored_ || wall - WallOf(deadline) > kReanchorAfter) {
      anchored_ = true;
      anchor_ = deadline;
      wall_anchor_ = wall;
    }
    last_slept_ = deadline;
    return {.wall_lateness = MonotonicSleepUntil(WallOf(deadline))};
  }

 private:
  static constexpr Nanoseconds kReanchorAfter = std::chrono::seconds(1);

  Nanoseconds WallOf(Nanoseconds deadline) const {
    return wall_anchor_ + Nanoseconds(static_cast<std::int64_t>(
                              static_cast<double>((deadline - anchor_).count()) / speed_));
  }

  const double speed_;
  const Nanoseconds grain_;
  std::atomic<std::int64_t> now_{0};
  bool anchored_ = false;
  Nanoseconds anchor_{0};
  Nanoseconds wall_anchor_{0};
  Nanoseconds last_slept_{0};
};

}  // namespace

std::shared_ptr<Clock> MakeSteadyClock() {
  return std::make_shared<SteadyClock>();
}

std::shared_ptr<Clock> MakeFollowingClock() {
  return std::make_shared<FollowingClock>();
}

std::shared_ptr<Clock> MakeSimulatedClock(double speed, Nanoseconds grain) {
  LAB_CHECK(speed >= 0.0, speed);
  return std::make_shared<SimulatedClock>(speed, grain);
}

}  // namespace faultlab::hardware
