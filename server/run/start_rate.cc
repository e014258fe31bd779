#include "server/run/start_rate.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace faultlab::server {
namespace {

/// Above it, the buckets that have filled again are taken out.
constexpr std::size_t kBucketsMax = 1000;

}  // namespace

double StartRate::LeftAt(const Bucket& bucket, MonotonicTime now) const {
  const double passed_s = std::chrono::duration<double>(now - bucket.at).count();
  return std::min(burst_, bucket.left + per_s_ * passed_s);
}

core::Status StartRate::Take(const std::string& caller, MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  if (buckets_.size() >= kBucketsMax) {
    std::erase_if(buckets_, [&](const auto& entry) { return LeftAt(entry.second, now) >= burst_; });
  }
  Bucket& bucket = buckets_.try_emplace(caller, Bucket{burst_, now}).first->second;
  bucket = {LeftAt(bucket, now), now};
  if (bucket.left < 1.0) {
    return core::Refuse("runs_too_fast",
                        "",
                        {{"seconds", static_cast<int>(std::ceil((1.0 - bucket.left) / per_s_))}});
  }
  bucket.left -= 1.0;
  return core::Done{};
}

}  // namespace faultlab::server
