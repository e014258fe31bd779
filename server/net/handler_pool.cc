#include "server/net/handler_pool.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

namespace faultlab::server {

void HandlerPool::Start() {
  for (int i = 0; i < limits_.threads; ++i) threads_.emplace_back([this] { Work(); });
}

void HandlerPool::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

void HandlerPool::Join() {
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

HandlerPool::Room HandlerPool::RoomFor(const Turn& turn) const {
  const std::lock_guard lock(mutex_);
  if (closed_ || waiting_ >= limits_.waiting_max) return Room::kFull;
  std::size_t of_caller = 0;
  for (const auto& [name, lane] : lanes_) {
    of_caller += lane.queue.SizeOf(turn.caller);
    const bool full = limits_.threads_per_lane > 0 && lane.queue.size() >= limits_.waiting_max / 2;
    if (full && name == turn.lane) return Room::kFull;
  }
  return of_caller >= limits_.waiting_per_caller_max ? Room::kCallerFull : Room::kFree;
}

std::size_t HandlerPool::waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

void HandlerPool::Push(const Turn& turn, Task task) {
  const std::lock_guard lock(mutex_);
  lanes_[turn.lane].queue.Push(turn.caller, std::move(task));
  ++waiting_;
  changed_.notify_one();
}

/// The lane after the last one used that has waiting work and may use one more thread; the end if
/// there is none.
HandlerPool::Lanes::iterator HandlerPool::NextLane() {
  const auto ready = [this](const Lanes::value_type& entry) {
    const Lane& lane = entry.second;
    return lane.queue.size() > 0 &&
           (limits_.threads_per_lane == 0 || lane.at_work < limits_.threads_per_lane);
  };
  const auto behind = lanes_.upper_bound(last_lane_);
  const auto next = std::find_if(behind, lanes_.end(), ready);
  if (next != lanes_.end()) return next;
  const auto before = std::find_if(lanes_.begin(), behind, ready);
  return before == behind ? lanes_.end() : before;
}

void HandlerPool::Work() {
  // On Linux this changes only this thread; if refused, the priority stays.
  if (limits_.nice > 0) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), limits_.nice);
  std::unique_lock lock(mutex_);
  for (;;) {
    auto next = lanes_.end();
    changed_.wait(lock, [&] { return (next = NextLane()) != lanes_.end() || closed_; });
    // Closed, and no lane may use one more thread: the threads that serve the lanes now do their
    // remaining work.
    if (next == lanes_.end()) return;
    last_lane_ = next->first;
    Lane& lane = next->second;
    std::optional<Task> task = lane.queue.Pop();
    --waiting_;
    ++lane.at_work;
    lock.unlock();
    (*task)();
    task.reset();
    lock.lock();
    if (--lane.at_work == 0 && lane.queue.size() == 0) lanes_.erase(next);
  }
}

}  // namespace faultlab::server
