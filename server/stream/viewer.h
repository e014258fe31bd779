#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/clock.h"
#include "server/net/websocket.h"
#include "server/stream/client_message.h"
#include "server/stream/viewer_owner.h"

namespace faultlab::server {

/// The bytes of one WebSocket frame, shared by all viewers that receive it.
using SharedBytes = std::shared_ptr<const std::string>;

/// One socket of a browser, for the hub's thread: the waiting messages, and what is known of the
/// peer. Owns the descriptor.
///
///   Send -> empty queue: send(MSG_DONTWAIT) at once  -> all gone: done
///        -> socket full: queue of at most `ring_messages`, oldest frames dropped and counted;
///           too many messages that may not be dropped, or too many bytes of them: kFull
class Viewer {
 public:
  enum class Sent { kAll, kQueued, kFull, kBroken };

  /// @param text_bytes_max  for messages that may not be dropped, except the one that is being sent
  Viewer(std::uint64_t id, int fd, std::size_t ring_messages, std::size_t text_bytes_max);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /// @param samples  > 0: a signal frame, which may be dropped; 0: a message that may not.
  /// kFull: the peer does not read, and `bytes` are not kept. kBroken: the peer is gone.
  Sent Send(const SharedBytes& bytes, int samples);
  /// Drops waiting messages, except one that is half sent.
  void Forget();
  /// After the socket became writable. kAll: the queue is empty.
  Sent Flush();

  std::uint64_t id() const { return id_; }
  int fd() const { return fd_; }
  bool drained() const { return queue_.empty(); }

  /// Samples dropped since the last call; the caller then tells the peer.
  std::int64_t TakeDropped();
  std::uint64_t dropped_messages() const { return dropped_messages_; }

  // State that the hub stores with the socket.
  websocket::FrameReader reader{kClientMessageBytesMax};
  std::size_t channel = 0;     ///< slot in the hub
  std::int64_t catch_up = -1;  ///< next index of history to send; -1: live
  MonotonicTime last_heard{};
  MonotonicTime last_ping{};
  MonotonicTime rate_window{};
  std::optional<MonotonicTime> close_by;  ///< a close frame is on its way
  int messages_in_window = 0;
  int refusals = 0;
  ViewerOwner owner;
  bool can_command = false;
  bool waits_for_write = false;  ///< registered for EPOLLOUT
  bool broken = false;           ///< to be removed by the hub

 private:
  struct Waiting {
    SharedBytes bytes;
    int samples;
  };
  /// Whether one more message of this kind and size may wait; drops frames for it if necessary.
  bool MakeRoom(std::size_t bytes, int samples);
  /// Number of bytes that the socket accepted; -1 when it is broken.
  std::ptrdiff_t Write(const char* data, std::size_t size) const;

  std::uint64_t id_;
  int fd_;
  std::size_t ring_messages_;
  std::size_t text_bytes_max_;
  std::vector<Waiting> queue_;
  std::size_t front_sent_ = 0;  ///< bytes of queue_.front() already sent
  std::int64_t dropped_samples_ = 0;
  std::uint64_t dropped_messages_ = 0;
};

}  // namespace faultlab::server
