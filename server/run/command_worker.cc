#include "server/run/command_worker.h"

#include <utility>

namespace faultlab::server {

CommandWorker::CommandWorker(std::size_t waiting_max)
    : waiting_max_(waiting_max), thread_([this] { Loop(); }) {}

CommandWorker::~CommandWorker() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool CommandWorker::Submit(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (queue_.size() >= waiting_max_) return false;
    queue_.push_back(std::move(work));
  }
  changed_.notify_all();
  return true;
}

void CommandWorker::Loop() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || !queue_.empty(); });
    if (queue_.empty()) return;
    const auto work = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    work();
    lock.lock();
  }
}

}  // namespace faultlab::server
