#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <vector>

namespace faultlab::server {

/// Work that other threads pass to the hub's thread, which waits on fd() together with its sockets.
class HubInbox {
 public:
  /// @param droppable_max  when this much work waits, more droppable work is refused
  explicit HubInbox(std::size_t droppable_max) : droppable_max_(droppable_max) {}
  ~HubInbox();
  HubInbox(const HubInbox&) = delete;
  HubInbox& operator=(const HubInbox&) = delete;

  /// False, with errno, when the system has no descriptor left.
  bool Open();
  int fd() const { return fd_; }  ///< readable when work waits

  enum class Posted { kYes, kFull, kClosed };
  Posted Post(std::function<void()> work, bool droppable);  ///< any thread
  void Close();                                             ///< no more work is accepted
  bool closed() const;

  void RunAll();  ///< on the hub's thread: runs the work that waits now

 private:
  const std::size_t droppable_max_;
  int fd_ = -1;
  mutable std::mutex mutex_;
  std::vector<std::function<void()>> work_;
  bool closed_ = false;
};

}  // namespace faultlab::server
