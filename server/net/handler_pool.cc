#include "server/net/handler_pool.h"

#include <sys/resource.h>
#include <unistd.h>

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

HandlerPool::Room HandlerPool::RoomFor(const std::string& caller) const {
  const std::lock_guard lock(mutex_);
  if (closed_ || queue_.size() >= limits_.waiting_max) return Room::kFull;
  return queue_.SizeOf(caller) >= limits_.waiting_per_caller_max ? Room::kCallerFull : Room::kFree;
}

std::size_t HandlerPool::waiting() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

void HandlerPool::Push(const std::string& caller, Task task) {
  const std::lock_guard lock(mutex_);
  queue_.Push(caller, std::move(task));
  changed_.notify_one();
}

void HandlerPool::Work() {
  // On Linux this is the thread's own; a refusal leaves it as it is.
  if (limits_.nice > 0) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), limits_.nice);
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return closed_ || queue_.size() > 0; });
    std::optional<Task> task = queue_.Pop();
    if (!task) return;  // closed, and all that was taken is done
    lock.unlock();
    (*task)();
    task.reset();
    lock.lock();
  }
}

}  // namespace faultlab::server
