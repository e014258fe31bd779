#include "server/api/transfer_quota.h"

namespace faultlab::server {

std::shared_ptr<void> TransferQuota::Place(const std::string& key, int places) {
  {
    const std::lock_guard lock(taken_->mutex);
    int& count = taken_->of_caller[key];
    if (count >= places) return nullptr;
    ++count;
  }
  // Not null, and not owned by this pointer: it only carries the deleter.
  return {taken_.get(), [taken = taken_, key](void*) {
            const std::lock_guard lock(taken->mutex);
            const auto entry = taken->of_caller.find(key);
            if (--entry->second == 0) taken->of_caller.erase(entry);
          }};
}

}  // namespace faultlab::server
