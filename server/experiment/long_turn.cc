#include "server/experiment/long_turn.h"

namespace faultlab::server {

core::Result<LongTurn::Hold> LongTurn::ForSamples(std::int64_t samples, WhenTaken when_taken) {
  if (samples <= kShortSamplesMax) return Hold();
  return Take(when_taken);
}

core::Result<LongTurn::Hold> LongTurn::ForText(std::size_t bytes) {
  if (bytes <= kShortTextBytesMax) return Hold();
  return Take(WhenTaken::kRefuse);
}

core::Result<LongTurn::Hold> LongTurn::Take(WhenTaken when_taken) {
  std::unique_lock lock(state_->mutex);
  if (state_->taken && when_taken == WhenTaken::kRefuse) {
    return core::Error{core::ErrorCode::kUnavailable,
                       "The server works on another long recording; try again in some seconds.",
                       "",
                       "long_recording_waits"};
  }
  state_->returned.wait(lock, [this] { return !state_->taken; });
  state_->taken = true;
  // Not null, and does not own what it points to: it only carries the deleter.
  return Hold(state_.get(), [state = state_](void*) {
    {
      const std::lock_guard returning(state->mutex);
      state->taken = false;
    }
    state->returned.notify_one();
  });
}

}  // namespace faultlab::server
