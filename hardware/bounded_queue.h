#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <iterator>
#include <mutex>
#include <utility>
#include <vector>

namespace faultlab::hardware {

/// A queue of at most `capacity` items between one writer and one reader, each in its own thread.
/// The reader takes all there is at once. Closing lets the reader drain what is left.
template <typename T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

  /// @returns false and leaves `item` alone when the queue is full.
  bool TryPush(T&& item) {
    const std::lock_guard lock(mutex_);
    if (items_.size() >= capacity_) return false;
    Add(std::move(item));
    return true;
  }

  /// Waits for room until `deadline`. `give_up` is asked at each wake-up (see Wake).
  bool PushUntil(T&& item,
                 std::chrono::steady_clock::time_point deadline,
                 const std::function<bool()>& give_up) {
    std::unique_lock lock(mutex_);
    room_.wait_until(lock, deadline, [&] { return items_.size() < capacity_ || give_up(); });
    if (items_.size() >= capacity_) return false;
    Add(std::move(item));
    return true;
  }

  /// Waits until the reader has taken everything and has come back for more, until `deadline`.
  /// `give_up` is asked at each wake-up (see Wake).
  bool WaitUntilRead(std::chrono::steady_clock::time_point deadline,
                     const std::function<bool()>& give_up) {
    std::unique_lock lock(mutex_);
    room_.wait_until(lock, deadline, [&] { return closed_ || caught_up_ || give_up(); });
    return closed_ || caught_up_;
  }

  /// For the few last words of a writer, which must not be lost: ignores the bound.
  void PushLast(T&& item) {
    const std::lock_guard lock(mutex_);
    Add(std::move(item));
  }

  /// Lets a writer that waits for room ask its give_up.
  void Wake() {
    const std::lock_guard lock(mutex_);
    room_.notify_all();
  }

  /// Appends all items to `out`, waiting up to `patience` for the first.
  /// @returns false when the queue is closed and nothing is left after this call.
  bool TakeAll(std::vector<T>& out, std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (items_.empty() && !closed_) {
      caught_up_ = true;
      room_.notify_all();
      filled_.wait_for(lock, patience, [this] { return !items_.empty() || closed_; });
    }
    if (out.empty()) {
      out.swap(items_);
    } else {
      std::move(items_.begin(), items_.end(), std::back_inserter(out));
    }
    items_.clear();
    room_.notify_all();
    return !closed_;
  }

  void Close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    filled_.notify_all();
    room_.notify_all();
  }

  /// Empty and open again, for the next run.
  void Reopen() {
    const std::lock_guard lock(mutex_);
    items_.clear();
    closed_ = false;
  }

 private:
  void Add(T&& item) {
    items_.push_back(std::move(item));
    caught_up_ = false;
    filled_.notify_one();
  }

  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable room_;
  std::vector<T> items_;
  bool closed_ = true;
  bool caught_up_ = false;  ///< the reader has come for more since the newest item
};

}  // namespace faultlab::hardware
