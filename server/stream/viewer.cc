#include "server/stream/viewer.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace faultlab::server {

Viewer::Viewer(std::uint64_t id, int fd, std::size_t ring_messages, std::size_t text_bytes_max)
    : id_(id), fd_(fd), ring_messages_(ring_messages), text_bytes_max_(text_bytes_max) {}

Viewer::~Viewer() {
  ::close(fd_);
}

std::ptrdiff_t Viewer::Write(const char* data, std::size_t size) const {
  const ssize_t sent = ::send(fd_, data, size, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent >= 0) return sent;
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ? 0 : -1;
}

bool Viewer::MakeRoom(std::size_t bytes, int samples) {
  if (samples == 0) {
    std::size_t waiting = bytes;
    for (std::size_t i = 1; i < queue_.size(); ++i) {
      if (queue_[i].samples == 0) waiting += queue_[i].bytes->size();
    }
    if (waiting > text_bytes_max_) return false;
  }
  if (queue_.size() < ring_messages_) return true;
  // The first message may be half sent; dropping it would leave a broken frame in the stream.
  const auto first = queue_.begin() + (front_sent_ > 0 ? 1 : 0);
  const auto oldest =
      std::find_if(first, queue_.end(), [](const Waiting& waiting) { return waiting.samples > 0; });
  if (oldest == queue_.end()) return false;
  dropped_samples_ += oldest->samples;
  ++dropped_messages_;
  queue_.erase(oldest);
  return true;
}

Viewer::Sent Viewer::Send(const SharedBytes& bytes, int samples) {
  std::size_t done = 0;
  if (queue_.empty()) {
    const std::ptrdiff_t sent = Write(bytes->data(), bytes->size());
    if (sent < 0) return Sent::kBroken;
    done = static_cast<std::size_t>(sent);
    if (done == bytes->size()) return Sent::kAll;
    front_sent_ = done;
  } else if (!MakeRoom(bytes->size(), samples)) {
    return Sent::kFull;
  }
  queue_.push_back({bytes, samples});
  return Sent::kQueued;
}

void Viewer::Forget() {
  queue_.resize(front_sent_ > 0 ? 1 : 0);
}

Viewer::Sent Viewer::Flush() {
  std::size_t gone = 0;
  while (gone < queue_.size()) {
    const std::string& bytes = *queue_[gone].bytes;
    const std::ptrdiff_t sent = Write(bytes.data() + front_sent_, bytes.size() - front_sent_);
    if (sent < 0) return Sent::kBroken;
    front_sent_ += static_cast<std::size_t>(sent);
    if (front_sent_ < bytes.size()) break;
    front_sent_ = 0;
    ++gone;
  }
  queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(gone));
  if (!queue_.empty()) return Sent::kQueued;
  queue_.shrink_to_fit();
  return Sent::kAll;
}

std::int64_t Viewer::TakeDropped() {
  return std::exchange(dropped_samples_, 0);
}

}  // namespace faultlab::server
