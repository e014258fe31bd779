#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <vector>

#include "server/stream/hub_inbox.h"
#include "server/stream/row_history.h"
#include "server/stream/stream_hub.h"
#include "server/stream/viewer.h"

namespace faultlab::server {

/// The hub's thread: its epoll set, its viewers, its channels. Everything but Start, Stop, Post and
/// counters runs on that thread.
class HubLoop {
 public:
  HubLoop(StreamHubOptions options, const Clock& clock)
      : options_(options), clock_(clock), inbox_(options.inbox_messages_max) {}

  core::Status Start();
  void Stop();
  /// Runs `work` on the hub's thread. False when the inbox is full and the work may be dropped.
  bool Post(std::function<void()> work, bool droppable);

  // On the hub's thread.
  void OpenChannel(ChannelOptions options, std::string hello);
  void Publish(const std::string& run, std::int64_t first_index, std::vector<StreamRow> rows);
  void PublishText(const std::string& run, std::string_view text, std::string hello);
  void Reply(ViewerId viewer, std::string_view text);
  void CloseChannel(const std::string& run, std::string_view end_text, std::string hello);
  void Adopt(UpgradedSocket socket,
             const std::string& run,
             const ViewerOwner& owner,
             bool can_command);
  void CloseOf(const std::function<bool(const ViewerOwner&)>& which);
  std::vector<ViewerOwner> Owners() const;

  StreamCounters counters() const;

 private:
  struct Channel {
    ChannelOptions options;
    std::string hello;
    RowHistory history;
    std::vector<Viewer*> viewers;
    std::optional<MonotonicTime> ended;
    bool open = true;  ///< false: the slot may be used again
  };

  void Refuse(int fd, std::string_view why);
  void Loop();
  void Tick();
  void OnEvent(std::uint64_t id, std::uint32_t events);
  void OnReadable(Viewer& viewer);
  void OnMessage(Viewer& viewer, const websocket::FrameReader::Message& message);
  void OnText(Viewer& viewer, const std::string& text);
  void Deliver(Viewer& viewer, const SharedBytes& bytes, int samples);
  void DeliverText(Viewer& viewer, std::string_view text);
  /// Counts the error, sends it, and closes with `code`.
  void Reject(Viewer& viewer,
              websocket::CloseCode code,
              std::string_view why,
              std::string_view reason);
  void After(Viewer& viewer, Viewer::Sent sent);
  void CatchUp(Viewer& viewer);
  void Close(Viewer& viewer, websocket::CloseCode code, std::string_view reason);
  void Watch(Viewer& viewer, bool for_write);
  void RemoveBroken();
  void SendHello(Viewer& viewer, const Channel& channel);
  Channel* FindChannel(const std::string& run);
  double ServerSeconds(const Channel& channel) const {
    return std::chrono::duration<double>(clock_.Monotonic() - channel.options.started).count();
  }

  struct Counters {
    std::atomic<std::uint64_t> viewers{0}, viewers_total{0}, channels{0}, messages{0}, bytes{0},
        dropped{0}, inbox_refused{0}, protocol_errors{0};
  };

  StreamHubOptions options_;
  const Clock& clock_;
  Counters counters_;

  HubInbox inbox_;
  int epoll_fd_ = -1;
  std::thread thread_;

  std::unordered_map<std::uint64_t, std::unique_ptr<Viewer>> viewers_;
  std::unordered_map<std::string, std::size_t> of_caller_;  ///< number of viewers
  std::size_t guests_ = 0;                                  ///< number of guests among the viewers
  std::vector<std::unique_ptr<Channel>> channels_;
  std::unordered_map<std::string, std::size_t> channel_by_run_;
  std::uint64_t next_viewer_ = 1;
  MonotonicTime last_tick_{};
  bool any_broken_ = false;
};

}  // namespace faultlab::server
