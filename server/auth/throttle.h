#pragma once

#include <map>
#include <mutex>
#include <string>

#include "core/types/result.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// Slows down guessing: after `free_tries` failures under one name the wait doubles from 1 s to
/// 15 min; an hour of peace forgets. Holds at most 10 000 names, oldest leave first. Thread-safe.
class Throttle {
 public:
  explicit Throttle(int free_tries) : free_tries_(free_tries) {}

  /// kBusy with the seconds to wait.
  core::Status Check(const std::string& name, WallTime now);
  void Failed(const std::string& name, WallTime now);
  void Succeeded(const std::string& name);

 private:
  struct Failures {
    int count = 0;
    WallTime last{};
    WallTime wait_until{};
  };
  const int free_tries_;
  std::mutex mutex_;
  std::map<std::string, Failures> failures_;
};

}  // namespace faultlab::server
