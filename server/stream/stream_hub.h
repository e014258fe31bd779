#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/net/http_server.h"
#include "server/stream/client_message.h"
#include "server/stream/frame_codec.h"
#include "server/stream/viewer_owner.h"

namespace faultlab::server {

class HubLoop;

enum class ViewerId : std::uint64_t {};

struct StreamHubOptions {
  std::size_t viewers_max = 4096;  ///< guests together have at most half of them
  std::size_t viewers_per_caller_max = 256;
  std::size_t ring_messages = 64;           ///< per viewer, while its socket is full
  std::size_t text_bytes_max = 512 << 10;   ///< per viewer, of waiting texts
  std::size_t inbox_messages_max = 8192;    ///< between the runs and the hub
  std::size_t history_rows_max = 60'000;    ///< per channel, 100 bytes each
  int socket_send_buffer_bytes = 64 << 10;  ///< limits the age of the bytes in the kernel
  std::chrono::milliseconds ping_interval{15'000};
  std::chrono::milliseconds silence_max{45'000};  ///< no byte from a viewer for this long: closed
  std::chrono::milliseconds linger{30'000};       ///< a finished channel closes its viewers then
  int client_messages_per_s_max = 100;
};

struct StreamCounters {
  std::uint64_t viewers_open = 0;
  std::uint64_t viewers_total = 0;
  std::uint64_t channels_open = 0;
  std::uint64_t messages_sent = 0;
  std::uint64_t bytes_sent = 0;
  std::uint64_t messages_dropped = 0;  ///< from full viewer rings
  std::uint64_t inbox_refused = 0;     ///< messages refused because the inbox was full
  std::uint64_t protocol_errors = 0;
};

/// Receives the commands of viewers. Called on the hub's thread: must not block.
using CommandHandler = std::function<void(ViewerId viewer, const CommandMessage& command)>;

struct ChannelOptions {
  std::string run;
  MonotonicTime started;  ///< zero of t_server in frames and pongs
  CommandHandler on_command;
  /// False: a channel of texts only. Its hello is a complete message and sent unchanged.
  bool signals = true;
  /// True: nobody is expected to watch. It keeps few rows for who comes late, and ends at once
  /// where nobody has come.
  bool brief = false;
};

/// Live view: one thread, one epoll set, all viewers of all runs.
///
///   run thread --Publish--> inbox --> [hub thread] --send(MSG_DONTWAIT)--> viewers
///                                       |  history of each channel, for `resume`
///
/// A batch is framed once and the same bytes go to every viewer. If a viewer's socket is full, up
/// to `ring_messages` wait in a ring; then its oldest frames are dropped and it is told how many.
/// Texts are not dropped: a viewer that leaves `text_bytes_max` of them unread is closed with 1013.
/// A viewer cannot delay a run: Publish copies into a bounded inbox and returns. All public
/// functions are thread-safe.
class StreamHub {
 public:
  StreamHub(StreamHubOptions options, const Clock& clock);
  ~StreamHub();
  StreamHub(const StreamHub&) = delete;
  StreamHub& operator=(const StreamHub&) = delete;

  core::Status Start();
  void Stop();  ///< closes every viewer with 1001, joins

  /// @param hello  members of the hello message that the run knows, as JSON without braces:
  ///               `"run":"r1","state":"running",..`
  void OpenChannel(ChannelOptions options, std::string hello);
  /// Publishes consecutive rows without a gap; `first_index` of the next call is the end of this
  /// one.
  void Publish(std::string_view run, std::int64_t first_index, std::span<const StreamRow> rows);
  /// Sends a JSON text to every viewer; viewers that come later get `hello` (empty: unchanged).
  void PublishText(std::string_view run, std::string text, std::string hello = {});
  /// Sends a JSON text to one viewer.
  void Reply(ViewerId viewer, std::string text);
  /// Sends the last text of the run; viewers are closed with 1000 when they have received all and
  /// `linger` has passed.
  void CloseChannel(std::string_view run, std::string end_text, std::string hello);

  /// Takes ownership of the socket. Unknown run: closed with 1008. No room for one more viewer, for
  /// one more of this caller or for one more guest: closed with 1013.
  void Adopt(UpgradedSocket socket, std::string_view run, ViewerOwner owner, bool can_command);
  /// Closes the viewers of these owners with 1008, because the right by which they were opened has
  /// ended. Messages that they have sent and that are not yet read have no effect.
  void CloseOf(std::function<bool(const ViewerOwner&)> which);
  /// The owners of all viewers, one for each account, sign-in and key. Waits for the hub's thread;
  /// empty when that is stopping.
  std::vector<ViewerOwner> Owners();

  StreamCounters counters() const;

 private:
  std::unique_ptr<HubLoop> loop_;
};

}  // namespace faultlab::server
