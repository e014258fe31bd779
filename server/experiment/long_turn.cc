#include "server/experiment/long_turn.h"

namespace faultlab::server {

core::Result<LongTurn::Hold> LongTurn::ForSamples(std::int64_t samples, For whom) {
  if (samples <= limit_.samples) return Hold();
  return Take(whom);
}

core::Result<LongTurn::Hold> LongTurn::ForText(std::size_t bytes) {
  if (bytes <= limit_.text_bytes) return Hold();
  return Take(For::kPerson);
}

bool LongTurn::IsTaken(For whom) const {
  return Of(whom)->load();
}

core::Result<LongTurn::Hold> LongTurn::Take(For whom) {
  const std::shared_ptr<Taken>& taken = Of(whom);
  while (taken->exchange(true)) {
    if (whom == For::kGrading) {
      taken->wait(true);
      continue;
    }
    return core::Error{core::ErrorCode::kUnavailable,
                       "The server works on another long recording; try again in some seconds.",
                       "",
                       kTaken};
  }
  // Not null, and does not own what it points to: it only carries the deleter.
  return Hold(taken.get(), [taken](void*) {
    taken->store(false);
    taken->notify_one();
  });
}

}  // namespace faultlab::server
