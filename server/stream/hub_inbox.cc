#include "server/stream/hub_inbox.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>
#include <utility>

namespace faultlab::server {

HubInbox::~HubInbox() {
  if (fd_ >= 0) ::close(fd_);
}

bool HubInbox::Open() {
  fd_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  return fd_ >= 0;
}

HubInbox::Posted HubInbox::Post(std::function<void()> work, bool droppable) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return Posted::kClosed;
    if (droppable && work_.size() >= droppable_max_) return Posted::kFull;
    work_.push_back(std::move(work));
    if (work_.size() > 1) return Posted::kYes;  // the earlier work has already signalled
  }
  const std::uint64_t one = 1;
  // An eventfd refuses only after 2^64 - 2 unread signals: the hub is awake then.
  [[maybe_unused]] const ssize_t rung = ::write(fd_, &one, sizeof one);
  return Posted::kYes;
}

void HubInbox::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
}

bool HubInbox::closed() const {
  const std::lock_guard lock(mutex_);
  return closed_;
}

void HubInbox::RunAll() {
  std::uint64_t rung = 0;
  if (::read(fd_, &rung, sizeof rung) < 0) return;
  std::vector<std::function<void()>> work;
  {
    const std::lock_guard lock(mutex_);
    work.swap(work_);
  }
  for (const auto& item : work) item();
}

}  // namespace faultlab::server
