#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <string>

#include "core/types/result.h"
#include "server/clock.h"

namespace faultlab::server {

/// How often one caller may begin a run, so that a script in a loop does not fill lists, searches
/// and the database of the others: `burst` at once, then `per_s` each second (a token bucket).
/// Thread-safe.
class StartRate {
 public:
  StartRate(double burst, double per_s) : burst_(burst), per_s_(per_s) {}

  /// kTooMany with the seconds to wait; this one is then not counted.
  core::Status Take(const std::string& caller, MonotonicTime now);

 private:
  struct Bucket {
    double left = 0.0;
    MonotonicTime at;
  };
  double LeftAt(const Bucket& bucket, MonotonicTime now) const;

  const double burst_;
  const double per_s_;
  std::mutex mutex_;
  std::map<std::string, Bucket> buckets_;  ///< those that are not full
};

}  // namespace faultlab::server
