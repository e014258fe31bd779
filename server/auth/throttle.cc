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
constexpr int kDoublingsMax = 10;

milliseconds WaitAfter(int failures, int free_tries) {
  const int beyond = failures - free_tries;
  if (beyond < 0) return milliseconds(0);
  return std::min<milliseconds>(seconds(1) * (1LL << std::min(beyond, kDoublingsMax)), kWaitMax);
}

core::Error Wait(milliseconds left) {
  return core::Refuse(
      "sign_in_throttled", "", {{"seconds", std::chrono::ceil<seconds>(left).count()}});
}

}  // namespace

core::Status Throttle::Try(const std::string& name, WallTime now) {
  const std::lock_guard lock(mutex_);
  if (failures_.size() >= kNamesMax && !failures_.contains(name)) {
    failures_.erase(std::ranges::min_element(
        failures_, [](const auto& a, const auto& b) { return a.second.last < b.second.last; }));
  }
  Failures& entry = failures_[name];
  const milliseconds wait = WaitAfter(entry.count, free_tries_);
  const auto since = std::chrono::duration_cast<milliseconds>(now - entry.last);
  // A clock that was set back must not lock people out for longer than the longest wait.
  const bool clock_went_back = since < -kWaitMax;
  if (clock_went_back || since > hours(1)) entry = {};
  if (entry.count > 0 && since < wait) return Wait(std::min(wait - since, kWaitMax));
  ++entry.count;
  entry.last = now;
  return core::Done{};
}

bool Throttle::Knows(const std::string& name) {
  const std::lock_guard lock(mutex_);
  return failures_.contains(name);
}

void Throttle::Forgive(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto found = failures_.find(name);
  if (found != failures_.end() && --found->second.count <= 0) failures_.erase(found);
}

void Throttle::Forget(const std::string& name) {
  const std::lock_guard lock(mutex_);
  failures_.erase(name);
}

}  // namespace faultlab::server
