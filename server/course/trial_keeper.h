#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string_view>

#include "server/clock.h"
#include "server/course/trials.h"

namespace faultlab::server::course {

/// Releases answered trials that are due, and grades anew those that have an older rubric, before
/// anybody looks: a class in minutes. Of servers that share a database each does so; the second
/// finds it done.
class TrialKeeper {
 public:
  /// BlindTrials::Look.
  using LookAt = std::function<core::Status(std::int64_t trial)>;
  using Log = std::function<void(std::string_view)>;
  TrialKeeper(Database& database, LookAt look, Log log, const Clock& clock)
      : trials_(database), look_(std::move(look)), log_(std::move(log)), clock_(clock) {}

  /// Looks for about a second, since others wait for this thread; when all have been looked at,
  /// again after a while. One that cannot be graded is in the log, once, and does not keep the
  /// others from it.
  core::Status Step(WallTime now);

 private:
  core::Status Look(std::int64_t trial) const;

  Trials trials_;
  const LookAt look_;
  const Log log_;
  const Clock& clock_;
  MonotonicTime look_at_{};     ///< when the next are looked at
  std::int64_t looked_at_ = 0;  ///< the last of those that have been
  std::set<std::int64_t> failed_;
};

}  // namespace faultlab::server::course
