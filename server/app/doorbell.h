#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>

namespace faultlab::server {

/// Wakes the one thread that waits for it. A ring while nobody waits is not lost; several rings
/// count once.
class Doorbell {
 public:
  void Ring() {
    {
      const std::lock_guard lock(mutex_);
      rung_ = true;
    }
    wake_.notify_one();
  }
  /// Blocks until somebody rings, or, if `until` is given, until that time.
  void Await(std::optional<std::chrono::steady_clock::time_point> until) {
    std::unique_lock lock(mutex_);
    const auto rung = [this] { return rung_; };
    if (until) {
      wake_.wait_until(lock, *until, rung);
    } else {
      wake_.wait(lock, rung);
    }
    rung_ = false;
  }

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  bool rung_ = false;
};

}  // namespace faultlab::server
