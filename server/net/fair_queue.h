#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace faultlab::server {

/// A queue in which callers take turns: a caller with a hundred waiting tasks does not delay a
/// caller with one. Not thread-safe.
template <typename Task>
class FairQueue {
 public:
  void Push(const std::string& caller, Task task) {
    std::deque<Task>& own = tasks_[caller];
    if (own.empty()) turns_.push_back(caller);
    own.push_back(std::move(task));
    ++size_;
  }

  /// The oldest task of the caller whose turn it is; nothing if the queue is empty.
  std::optional<Task> Pop() {
    if (turns_.empty()) return std::nullopt;
    const std::string caller = std::move(turns_.front());
    turns_.pop_front();
    const auto own = tasks_.find(caller);
    std::optional<Task> task(std::move(own->second.front()));
    own->second.pop_front();
    --size_;
    if (own->second.empty()) {
      tasks_.erase(own);
    } else {
      turns_.push_back(caller);
    }
    return task;
  }

  std::size_t size() const { return size_; }
  std::size_t SizeOf(const std::string& caller) const {
    const auto own = tasks_.find(caller);
    return own == tasks_.end() ? 0 : own->second.size();
  }

 private:
  std::map<std::string, std::deque<Task>> tasks_;  ///< no entry is empty
  std::deque<std::string> turns_;                  ///< callers in `tasks_`, each once
  std::size_t size_ = 0;
};

}  // namespace faultlab::server
