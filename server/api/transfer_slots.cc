#include "server/api/transfer_slots.h"

namespace faultlab::server {

std::shared_ptr<void> TransferSlots::Take(const std::string& caller) {
  {
    const std::lock_guard lock(taken_->mutex);
    int& count = taken_->of_caller[caller];
    if (count >= per_caller_) return nullptr;
    ++count;
  }
  // Not null, and not owned by this pointer: it only carries the deleter.
  return {taken_.get(), [taken = taken_, caller](void*) {
            const std::lock_guard lock(taken->mutex);
            const auto entry = taken->of_caller.find(caller);
            if (--entry->second == 0) taken->of_caller.erase(entry);
          }};
}

bool TransferSlots::Full(const std::string& caller) const {
  const std::lock_guard lock(taken_->mutex);
  const auto entry = taken_->of_caller.find(caller);
  return entry != taken_->of_caller.end() && entry->second >= per_caller_;
}

}  // namespace faultlab::server
