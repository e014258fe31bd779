#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <vector>

namespace faultlab::server {

/// Work that other threads hand to the hub's thread, which waits for it on fd() with its sockets.
class HubInbox {
 public:
  /// @param droppable_max  this much work waiting: more of the droppable kind is refused
  explicit HubInbox(std::size_t droppable_max) : droppable_max_(droppable_max) {}
  ~HubInbox();
  HubInbox(const HubInbox&) = delete;
  HubInbox& operator=(const HubInbox&) = delete;

  /// False, with errno, when the system has no descriptor left.
  bool Open();
  int fd() const { return fd_; }  ///< readable when work waits

  enum class Posted { kYes, kFull, kClosed };
  Posted Post(std::function<void()> work, bool droppable);  ///< any thread
  void Close();                                             ///< nothing is taken from now on
  bool closed() const;

  void RunAll();  ///< on the hub's thread: what waits now

 private:
  const std::size_t droppable_max_;
  int fd_ = -1;
  mutable std::mutex mutex_;
  std::vector<std::function<void()>> work_;
  bool closed_ = false;
};

}  // namespace faultlab::server
