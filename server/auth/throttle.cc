#include "server/auth/throttle.h"

#include <algorithm>

namespace faultlab::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr std::size_t kNamesMax = 10'000;
constexpr milliseconds kWaitMax = minutes(15);

}  // namespace

core::Status Throttle::Check(const std::string& name, WallTime now) {
  const std::lock_guard lock(mutex_);
  const auto found = failures_.find(name);
  if (found == failures_.end()) return core::Done{};
  // A clock set back must not lock people out for longer than the longest wait.
  const bool clock_went_back = found->second.wait_until > now + kWaitMax;
  if (clock_went_back || now - found->second.last > hours(1)) {
    failures_.erase(found);
    return core::Done{};
  }
  if (now >= found->second.wait_until) return core::Done{};
  const auto wait = std::chrono::ceil<seconds>(found->second.wait_until - now);
  return core::Error{core::ErrorCode::kBusy,
                     "too many failed attempts; wait " + std::to_string(wait.count()) + " s",
                     ""};
}

void Throttle::Failed(const std::string& name, WallTime now) {
  const std::lock_guard lock(mutex_);
  if (failures_.size() >= kNamesMax && !failures_.contains(name)) {
    failures_.erase(
        std::min_element(failures_.begin(), failures_.end(), [](const auto& a, const auto& b) {
          return a.second.last < b.second.last;
        }));
  }
  Failures& entry = failures_[name];
  ++entry.count;
  entry.last = now;
  const int beyond = entry.count - free_tries_;
  if (beyond < 0) return;
  const milliseconds wait = seconds(1) * (1LL << std::min(beyond, 10));
  entry.wait_until = now + std::min(wait, kWaitMax);
}

void Throttle::Succeeded(const std::string& name) {
  const std::lock_guard lock(mutex_);
  failures_.erase(name);
}

}  // namespace faultlab::server
