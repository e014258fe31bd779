#pragma once

#include <map>
#include <mutex>
#include <string>

#include "core/types/result.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// Slows down guessing: after `free_tries` failures under one name the wait doubles from 1 s to 15
/// min; after an hour without failures the name is cleared. A try counts as a failure from its
/// start, so a hundred tries at the same moment count as a hundred. Holds at most 10 000 names; the
/// oldest are removed first. Thread-safe.
class Throttle {
 public:
  explicit Throttle(int free_tries) : free_tries_(free_tries) {}

  /// kTooMany with the seconds to wait; this try is then not counted.
  core::Status Try(const std::string& name, WallTime now);
  /// Whether a failure under this name is stored.
  bool Knows(const std::string& name);
  /// The try that was begun is not a failure.
  void Forgive(const std::string& name);
  /// Clears this name: the earlier tries are not failures either.
  void Forget(const std::string& name);

 private:
  struct Failures {
    int count = 0;
    WallTime last{};
  };
  const int free_tries_;
  std::mutex mutex_;
  std::map<std::string, Failures> failures_;
};

}  // namespace faultlab::server
