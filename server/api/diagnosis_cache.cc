#include "server/api/diagnosis_cache.h"

namespace faultlab::server {

DiagnosisCache::Shared DiagnosisCache::Get(std::string_view run,
                                           const std::function<core::Diagnosis()>& make) {
  const std::string key(run);
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = by_run_.find(key); found != by_run_.end()) {
      order_.splice(order_.begin(), order_, found->second);
      return found->second->second;
    }
  }
  auto made = std::make_shared<const core::Diagnosis>(make());
  const std::lock_guard lock(mutex_);
  if (const auto found = by_run_.find(key); found != by_run_.end()) return found->second->second;
  order_.emplace_front(key, made);
  by_run_.emplace(key, order_.begin());
  if (order_.size() > runs_max_) {
    by_run_.erase(order_.back().first);
    order_.pop_back();
  }
  return made;
}

}  // namespace faultlab::server
