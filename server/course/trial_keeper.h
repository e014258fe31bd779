#pragma once

#include <cstdint>
#include <functional>

#include "server/clock.h"
#include "server/course/trials.h"

namespace faultlab::server::course {

/// Releases what is due, and grades anew what has an older rubric, before anybody looks: a class
/// in minutes. Of servers that share a database each does so; the second finds it done.
class TrialKeeper {
 public:
  /// BlindTrials::Look.
  using LookAt = std::function<core::Status(std::int64_t trial)>;
  TrialKeeper(Database& database, LookAt look, const Clock& clock)
      : trials_(database), look_(std::move(look)), clock_(clock) {}

  /// Looks at a few, since others wait for this thread; when all have been looked at, again after a
  /// while. One that cannot be graded does not keep the others from it.
  core::Status Step(WallTime now);

 private:
  Trials trials_;
  const LookAt look_;
  const Clock& clock_;
  MonotonicTime look_at_{};     ///< when the next are looked at
  std::int64_t looked_at_ = 0;  ///< the last of those that have been
};

}  // namespace faultlab::server::course
