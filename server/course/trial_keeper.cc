#include "server/course/trial_keeper.h"

#include <chrono>

#include "server/storage/database_error.h"

namespace faultlab::server::course {
namespace {

constexpr auto kLookEvery = std::chrono::minutes(1);

}  // namespace

core::Status TrialKeeper::Step(WallTime now) {
  const MonotonicTime at = clock_.Monotonic();
  if (at < look_at_) return core::Done{};
  TRY(const auto trials, trials_.Overdue(looked_at_, now));
  for (const std::int64_t trial : trials) {
    const core::Status looked = look_(trial);
    if (!looked.ok() && looked.error().reason == kDatabaseAway) return looked;
    looked_at_ = trial;
  }
  if (trials.empty()) {
    looked_at_ = 0;
    look_at_ = at + kLookEvery;
  }
  return core::Done{};
}

}  // namespace faultlab::server::course
