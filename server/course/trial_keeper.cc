#include "server/course/trial_keeper.h"

#include <chrono>
#include <exception>
#include <string>

#include "server/storage/database_error.h"

namespace faultlab::server::course {
namespace {

constexpr auto kLookEvery = std::chrono::minutes(1);
constexpr auto kBusy = std::chrono::seconds(1);
constexpr std::size_t kAtOnce = 500;

}  // namespace

/// What one trial holds ends nobody's thread.
core::Status TrialKeeper::Look(std::int64_t trial) const {
  try {
    return look_(trial);
  } catch (const std::exception& error) {
    return core::Error{core::ErrorCode::kUnavailable, error.what(), "", "internal"};
  }
}

core::Status TrialKeeper::Step(WallTime now) {
  const MonotonicTime at = clock_.Monotonic();
  if (at < look_at_) return core::Done{};
  TRY(const auto trials, trials_.Overdue(looked_at_, kAtOnce, now));
  for (const std::int64_t trial : trials) {
    if (clock_.Monotonic() - at > kBusy) return core::Done{};
    const core::Status looked = Look(trial);
    if (!looked.ok() && looked.error().reason == kDatabaseAway) return looked;
    if (!looked.ok() && failed_.insert(trial).second) {
      log_("trial " + std::to_string(trial) + " cannot be graded: " + looked.error().message);
    }
    looked_at_ = trial;
  }
  if (trials.size() == kAtOnce) return core::Done{};
  looked_at_ = 0;
  look_at_ = at + kLookEvery;
  return core::Done{};
}

}  // namespace faultlab::server::course
