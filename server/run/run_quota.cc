#include "server/run/run_quota.h"

#include <algorithm>

namespace faultlab::server {

core::Result<std::shared_ptr<void>> RunQuota::Take(const std::string& caller,
                                                   RunKind kind,
                                                   std::int64_t samples,
                                                   MonotonicTime now) {
  if (!caller.empty()) {
    TRY_DONE(rate_.Take(caller, now));
  }
  if (kind == RunKind::kLeased) return std::shared_ptr<void>();
  const int simulators = kind == RunKind::kSimulator ? 1 : 0;
  const bool is_guest = caller.starts_with("guest");
  {
    const std::lock_guard lock(taken_->mutex);
    if (taken_->all.runs >= limits_.runs_max) return core::Refuse("runs_full");
    if (taken_->replayed_samples + samples > limits_.replayed_samples_max) {
      return core::Refuse("runs_full");
    }
    if (!caller.empty()) {
      const auto found = taken_->of_caller.find(caller);
      const Count own = found == taken_->of_caller.end() ? Count{} : found->second;
      if (own.runs >= limits_.runs_per_caller_max) {
        return core::Refuse("your_runs_full", "", {{"most", limits_.runs_per_caller_max}});
      }
      if (own.simulators + simulators > limits_.simulators_per_caller) {
        return core::Refuse("your_simulators_full", "", {{"most", limits_.simulators_per_caller}});
      }
      const Count& guests = taken_->guests;
      if (is_guest && (guests.runs >= std::max(1, limits_.runs_max / 2) ||
                       guests.simulators + simulators > limits_.simulators_of_guests ||
                       guests.replayed + samples > limits_.replayed_samples_max / 2)) {
        return core::Refuse("runs_of_guests_full");
      }
      taken_->of_caller[caller].Add(1, simulators, samples);
      if (is_guest) taken_->guests.Add(1, simulators, samples);
    }
    ++taken_->all.runs;
    taken_->replayed_samples += samples;
  }
  // Not null, and does not own what it points to: it only carries the deleter.
  return std::shared_ptr<void>(taken_.get(), [=, taken = taken_](void*) {
    const std::lock_guard lock(taken->mutex);
    --taken->all.runs;
    taken->replayed_samples -= samples;
    if (caller.empty()) return;
    const auto own = taken->of_caller.find(caller);
    own->second.Add(-1, simulators, samples);
    if (own->second.runs == 0) taken->of_caller.erase(own);
    if (is_guest) taken->guests.Add(-1, simulators, samples);
  });
}

}  // namespace faultlab::server
