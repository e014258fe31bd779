#include "server/stream/stream_hub.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/types/check.h"
#include "server/stream/viewer.h"

namespace faultlab::server {
namespace {

using websocket::CloseCode;
using websocket::Opcode;

constexpr std::uint64_t kWakeUp = 0;  ///< epoll data of the inbox; viewers count from 1
constexpr int kTickMilliseconds = 250;
constexpr int kCatchUpRows = 50;           ///< per frame
constexpr int kCatchUpFramesPerTurn = 16;  ///< then the others have their turn
constexpr int kRefusalsMax = 20;
constexpr std::chrono::milliseconds kClosePatience{2000};

SharedBytes Shared(std::string bytes) {
  return std::make_shared<const std::string>(std::move(bytes));
}

SharedBytes SharedText(std::string_view text) {
  return Shared(websocket::EncodeFrame(Opcode::kText, text));
}

std::string ChannelListJson() {
  std::string out = "\"channels\":[";
  for (const std::string& name : ChannelNames()) out.append("\"").append(name).append("\",");
  out.back() = ']';
  out.append(",\"estimators\":[");
  for (const core::EstimatorShape& shape : core::kEstimatorShapes) {
    out.append("\"").append(shape.name).append("\",");
  }
  out.back() = ']';
  return out;
}

std::string ErrorText(std::string_view message) {
  std::string text = "{\"type\":\"error\",\"message\":";
  AppendJsonString(text, message);
  text.push_back('}');
  return text;
}

StreamRow AbsentRow() {
  StreamRow row{};
  row.values.fill(static_cast<float>(core::kAbsent));
  std::fill_n(row.statuses.begin(),
              core::kEstimatorCount,
              static_cast<std::uint8_t>(core::EstimateStatus::kInvalid));
  return row;
}

}  // namespace

class StreamHub::Impl {
 public:
  Impl(StreamHubOptions options, const Clock& clock) : options_(options), clock_(clock) {}

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
  void Adopt(UpgradedSocket socket, const std::string& run, bool can_command);

  StreamCounters counters() const;

 private:
  struct Channel {
    ChannelOptions options;
    std::string hello;
    std::vector<StreamRow> history;
    std::int64_t history_first = 0;
    std::int64_t next_index = 0;
    std::vector<Viewer*> viewers;
    std::optional<MonotonicTime> ended;
    bool open = true;  ///< false: the slot may be used again
  };

  void Loop();
  void RunInbox();
  void Tick();
  void OnEvent(std::uint64_t id, std::uint32_t events);
  void OnReadable(Viewer& viewer);
  void OnMessage(Viewer& viewer, const websocket::FrameReader::Message& message);
  void OnText(Viewer& viewer, const std::string& text);
  void Deliver(Viewer& viewer, const SharedBytes& bytes, int samples);
  void After(Viewer& viewer, Viewer::Sent sent);
  void CatchUp(Viewer& viewer);
  void Close(Viewer& viewer, CloseCode code, std::string_view reason);
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

  std::mutex inbox_mutex_;
  std::vector<std::function<void()>> inbox_;
  bool stop_asked_ = false;

  int epoll_fd_ = -1;
  int wake_fd_ = -1;
  std::thread thread_;

  std::unordered_map<std::uint64_t, std::unique_ptr<Viewer>> viewers_;
  std::vector<std::unique_ptr<Channel>> channels_;
  std::unordered_map<std::string, std::size_t> channel_by_run_;
  std::uint64_t next_viewer_ = 1;
  MonotonicTime last_tick_{};
  bool any_broken_ = false;
};

core::Status StreamHub::Impl::Start() {
  epoll_fd_ = epoll_create1(EPOLL_CLOEXEC);
  wake_fd_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = kWakeUp;
  if (epoll_fd_ < 0 || wake_fd_ < 0 || epoll_ctl(epoll_fd_, EPOLL_CTL_ADD, wake_fd_, &event) != 0) {
    return core::Error{core::ErrorCode::kUnavailable,
                       std::string("cannot watch sockets: ") + std::strerror(errno),
                       {}};
  }
  thread_ = std::thread([this] { Loop(); });
  return core::Done{};
}

void StreamHub::Impl::Stop() {
  if (!thread_.joinable()) return;
  Post(
      [this] {
        for (auto& [id, viewer] : viewers_) {
          Close(*viewer, CloseCode::kGoingAway, "the server stops");
        }
        const std::lock_guard lock(inbox_mutex_);
        stop_asked_ = true;
      },
      false);
  thread_.join();
  viewers_.clear();
  counters_.viewers = 0;
  ::close(epoll_fd_);
  ::close(wake_fd_);
}

bool StreamHub::Impl::Post(std::function<void()> work, bool droppable) {
  {
    const std::lock_guard lock(inbox_mutex_);
    if (stop_asked_) return false;
    if (droppable && inbox_.size() >= options_.inbox_messages_max) {
      ++counters_.inbox_refused;
      return false;
    }
    inbox_.push_back(std::move(work));
    if (inbox_.size() > 1) return true;  // the one before has rung
  }
  const std::uint64_t one = 1;
  // An eventfd refuses only when 2^64 - 2 rings are unheard: then the hub is awake anyway.
  [[maybe_unused]] const ssize_t rung = ::write(wake_fd_, &one, sizeof one);
  return true;
}

void StreamHub::Impl::RunInbox() {
  std::uint64_t rung = 0;
  if (::read(wake_fd_, &rung, sizeof rung) < 0) return;
  std::vector<std::function<void()>> work;
  {
    const std::lock_guard lock(inbox_mutex_);
    work.swap(inbox_);
  }
  for (const auto& item : work) item();
}

void StreamHub::Impl::Loop() {
  std::array<epoll_event, 256> events;
  for (;;) {
    {
      const std::lock_guard lock(inbox_mutex_);
      if (stop_asked_) return;
    }
    const int count =
        epoll_wait(epoll_fd_, events.data(), static_cast<int>(events.size()), kTickMilliseconds);
    for (int i = 0; i < count; ++i) {
      const epoll_event& event = events[static_cast<std::size_t>(i)];
      if (event.data.u64 == kWakeUp) {
        RunInbox();
      } else {
        OnEvent(event.data.u64, event.events);
      }
    }
    if (any_broken_) RemoveBroken();
    Tick();
  }
}

void StreamHub::Impl::Tick() {
  const MonotonicTime now = clock_.Monotonic();
  if (now - last_tick_ < std::chrono::milliseconds(kTickMilliseconds)) return;
  last_tick_ = now;
  static const SharedBytes ping = Shared(websocket::EncodeFrame(Opcode::kPing, "faultlab"));
  for (auto& [id, viewer] : viewers_) {
    const bool late_close = viewer->close_by && now >= *viewer->close_by;
    if (late_close || now - viewer->last_heard >= options_.silence_max) {
      viewer->broken = any_broken_ = true;
    } else if (!viewer->close_by && now - viewer->last_ping >= options_.ping_interval) {
      viewer->last_ping = now;
      Deliver(*viewer, ping, 0);
    }
  }
  for (auto& channel : channels_) {
    if (!channel->open || !channel->ended || now - *channel->ended < options_.linger) continue;
    for (Viewer* viewer : channel->viewers) {
      if (viewer->drained()) Close(*viewer, CloseCode::kNormal, "the run has ended");
    }
    if (!channel->viewers.empty()) continue;
    channel_by_run_.erase(channel->options.run);
    *channel = Channel{};
    channel->open = false;
    --counters_.channels;
  }
  if (any_broken_) RemoveBroken();
}

StreamHub::Impl::Channel* StreamHub::Impl::FindChannel(const std::string& run) {
  const auto found = channel_by_run_.find(run);
  return found == channel_by_run_.end() ? nullptr : channels_[found->second].get();
}

void StreamHub::Impl::OpenChannel(ChannelOptions options, std::string hello) {
  std::size_t slot = 0;
  while (slot < channels_.size() && channels_[slot]->open) ++slot;
  if (slot == channels_.size()) channels_.push_back(std::make_unique<Channel>());
  channel_by_run_[options.run] = slot;
  Channel& channel = *channels_[slot];
  channel = Channel{};
  channel.options = std::move(options);
  channel.hello = std::move(hello);
  ++counters_.channels;
}

void StreamHub::Impl::Publish(const std::string& run,
                              std::int64_t first_index,
                              std::vector<StreamRow> rows) {
  Channel* channel = FindChannel(run);
  if (channel == nullptr || rows.empty()) return;
  if (channel->history.empty()) channel->history_first = channel->next_index = first_index;
  const auto max = static_cast<std::int64_t>(options_.history_rows_max);
  if (first_index < channel->next_index || first_index - channel->next_index > max) {
    channel->history.clear();
    channel->history_first = channel->next_index = first_index;
  }
  channel->history.insert(channel->history.end(),
                          static_cast<std::size_t>(first_index - channel->next_index),
                          AbsentRow());
  channel->history.insert(channel->history.end(), rows.begin(), rows.end());
  channel->next_index = first_index + static_cast<std::int64_t>(rows.size());
  if (channel->history.size() > options_.history_rows_max) {
    // A tenth at a time, so that the copy is rare.
    const std::size_t excess = std::min(
        channel->history.size(),
        channel->history.size() - options_.history_rows_max + options_.history_rows_max / 10);
    channel->history.erase(channel->history.begin(),
                           channel->history.begin() + static_cast<std::ptrdiff_t>(excess));
    channel->history_first += static_cast<std::int64_t>(excess);
  }

  if (channel->viewers.empty()) return;
  const SharedBytes bytes = Shared(websocket::EncodeFrame(
      Opcode::kBinary, EncodeFrameMessage(rows, first_index, ServerSeconds(*channel))));
  for (Viewer* viewer : channel->viewers) {
    if (viewer->catch_up >= 0) {
      if (viewer->drained()) CatchUp(*viewer);
    } else {
      Deliver(*viewer, bytes, static_cast<int>(rows.size()));
    }
  }
}

void StreamHub::Impl::PublishText(const std::string& run,
                                  std::string_view text,
                                  std::string hello) {
  Channel* channel = FindChannel(run);
  if (channel == nullptr) return;
  if (!hello.empty()) channel->hello = std::move(hello);
  if (channel->viewers.empty() || text.empty()) return;
  const SharedBytes bytes = SharedText(text);
  for (Viewer* viewer : channel->viewers) Deliver(*viewer, bytes, 0);
}

void StreamHub::Impl::Reply(ViewerId viewer, std::string_view text) {
  const auto found = viewers_.find(static_cast<std::uint64_t>(viewer));
  if (found != viewers_.end()) Deliver(*found->second, SharedText(text), 0);
}

void StreamHub::Impl::CloseChannel(const std::string& run,
                                   std::string_view end_text,
                                   std::string hello) {
  Channel* channel = FindChannel(run);
  if (channel == nullptr) return;
  PublishText(run, end_text, std::move(hello));
  channel->ended = clock_.Monotonic();
  channel->options.on_command = nullptr;
}

void StreamHub::Impl::SendHello(Viewer& viewer, const Channel& channel) {
  static const std::string lists = ChannelListJson();
  std::string text = "{\"type\":\"hello\",";
  text.append(channel.hello);
  text.append(",\"first_index\":").append(std::to_string(channel.history_first));
  text.append(",\"next_index\":").append(std::to_string(channel.next_index));
  text.append(",").append(lists);
  text.append(viewer.can_command ? ",\"can_command\":true}" : ",\"can_command\":false}");
  Deliver(viewer, SharedText(text), 0);
}

void StreamHub::Impl::Adopt(UpgradedSocket socket, const std::string& run, bool can_command) {
  if (viewers_.size() >= options_.viewers_max) {
    const std::string bytes = websocket::EncodeClose(CloseCode::kTryAgainLater, "too many viewers");
    if (::send(socket.fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
      // Nobody to tell.
    }
    ::close(socket.fd);
    return;
  }
  const int on = 1;
  setsockopt(socket.fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  setsockopt(socket.fd,
             SOL_SOCKET,
             SO_SNDBUF,
             &options_.socket_send_buffer_bytes,
             sizeof options_.socket_send_buffer_bytes);
  const std::uint64_t id = next_viewer_++;
  auto owned = std::make_unique<Viewer>(id, socket.fd, options_.ring_messages);
  Viewer& viewer = *owned;
  epoll_event event{};
  event.events = EPOLLIN | EPOLLRDHUP;
  event.data.u64 = id;
  if (epoll_ctl(epoll_fd_, EPOLL_CTL_ADD, socket.fd, &event) != 0) return;
  viewer.last_heard = viewer.last_ping = viewer.rate_window = clock_.Monotonic();
  viewers_.emplace(id, std::move(owned));
  ++counters_.viewers;
  ++counters_.viewers_total;
  Channel* channel = FindChannel(run);
  if (channel == nullptr) {
    viewer.channel = channels_.size();
    Close(viewer, CloseCode::kPolicy, "no such run");
    return;
  }
  viewer.channel = channel_by_run_[run];
  viewer.can_command = can_command;
  channel->viewers.push_back(&viewer);
  SendHello(viewer, *channel);
  if (!socket.pending.empty()) {
    viewer.reader.Append(socket.pending);
    while (const auto message = viewer.reader.Next()) OnMessage(viewer, *message);
  }
}

void StreamHub::Impl::Watch(Viewer& viewer, bool for_write) {
  if (viewer.waits_for_write == for_write) return;
  epoll_event event{};
  event.events = EPOLLIN | EPOLLRDHUP | (for_write ? EPOLLOUT : 0U);
  event.data.u64 = viewer.id();
  epoll_ctl(epoll_fd_, EPOLL_CTL_MOD, viewer.fd(), &event);
  viewer.waits_for_write = for_write;
}

void StreamHub::Impl::Deliver(Viewer& viewer, const SharedBytes& bytes, int samples) {
  if (viewer.broken || viewer.close_by) return;
  counters_.messages.fetch_add(1, std::memory_order_relaxed);
  counters_.bytes.fetch_add(bytes->size(), std::memory_order_relaxed);
  const std::uint64_t dropped = viewer.dropped_messages();
  After(viewer, viewer.Send(bytes, samples));
  counters_.dropped += viewer.dropped_messages() - dropped;
}

void StreamHub::Impl::After(Viewer& viewer, Viewer::Sent sent) {
  if (sent == Viewer::Sent::kBroken) {
    viewer.broken = any_broken_ = true;
  } else if (sent == Viewer::Sent::kQueued) {
    Watch(viewer, true);
  }
}

void StreamHub::Impl::CatchUp(Viewer& viewer) {
  Channel& channel = *channels_[viewer.channel];
  for (int turn = 0; turn < kCatchUpFramesPerTurn && viewer.drained() && !viewer.broken; ++turn) {
    const std::int64_t from = std::max(viewer.catch_up, channel.history_first);
    if (from >= channel.next_index) {
      viewer.catch_up = -1;
      return;
    }
    const std::int64_t count = std::min<std::int64_t>(channel.next_index - from, kCatchUpRows);
    const auto rows = std::span<const StreamRow>(channel.history)
                          .subspan(static_cast<std::size_t>(from - channel.history_first),
                                   static_cast<std::size_t>(count));
    viewer.catch_up = from + count;
    Deliver(viewer,
            Shared(websocket::EncodeFrame(Opcode::kBinary,
                                          EncodeFrameMessage(rows, from, ServerSeconds(channel)))),
            static_cast<int>(count));
  }
  Watch(viewer, true);
}

void StreamHub::Impl::Close(Viewer& viewer, CloseCode code, std::string_view reason) {
  if (viewer.close_by || viewer.broken) return;
  Deliver(viewer, Shared(websocket::EncodeClose(code, reason)), 0);
  viewer.close_by = clock_.Monotonic() + kClosePatience;
  if (viewer.drained()) ::shutdown(viewer.fd(), SHUT_WR);
}

void StreamHub::Impl::OnEvent(std::uint64_t id, std::uint32_t events) {
  const auto found = viewers_.find(id);
  if (found == viewers_.end()) return;
  Viewer& viewer = *found->second;
  if (viewer.broken) return;
  if ((events & EPOLLOUT) != 0) {
    const Viewer::Sent sent = viewer.Flush();
    After(viewer, sent);
    if (sent == Viewer::Sent::kAll) {
      Watch(viewer, false);
      if (viewer.close_by) ::shutdown(viewer.fd(), SHUT_WR);
      if (const std::int64_t dropped = viewer.TakeDropped(); dropped > 0) {
        Deliver(viewer,
                SharedText("{\"type\":\"dropped\",\"samples\":" + std::to_string(dropped) + "}"),
                0);
      }
      if (viewer.catch_up >= 0 && !viewer.close_by) CatchUp(viewer);
    }
  }
  if ((events & (EPOLLIN | EPOLLRDHUP | EPOLLERR | EPOLLHUP)) != 0) OnReadable(viewer);
}

void StreamHub::Impl::OnReadable(Viewer& viewer) {
  std::array<char, 4096> bytes;
  const ssize_t got = ::recv(viewer.fd(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (got <= 0) {
    viewer.broken = any_broken_ = true;
    return;
  }
  if (viewer.close_by) return;  // read away until the peer closes
  viewer.last_heard = clock_.Monotonic();
  viewer.reader.Append({bytes.data(), static_cast<std::size_t>(got)});
  while (!viewer.broken && !viewer.close_by) {
    const auto message = viewer.reader.Next();
    if (!message) break;
    OnMessage(viewer, *message);
  }
  if (const auto error = viewer.reader.error(); error && !viewer.close_by) {
    ++counters_.protocol_errors;
    Deliver(viewer, SharedText(ErrorText("the WebSocket protocol was broken")), 0);
    Close(viewer, *error, "protocol error");
  }
}

void StreamHub::Impl::OnMessage(Viewer& viewer, const websocket::FrameReader::Message& message) {
  const MonotonicTime now = clock_.Monotonic();
  if (now - viewer.rate_window >= std::chrono::seconds(1)) {
    viewer.rate_window = now;
    viewer.messages_in_window = 0;
  }
  if (++viewer.messages_in_window > options_.client_messages_per_s_max) {
    ++counters_.protocol_errors;
    Close(viewer, CloseCode::kPolicy, "too many messages");
    return;
  }
  switch (message.opcode) {
    case Opcode::kPing:
      Deliver(viewer, Shared(websocket::EncodeFrame(Opcode::kPong, message.payload)), 0);
      return;
    case Opcode::kPong:
      return;
    case Opcode::kClose:
      Close(viewer, CloseCode::kNormal, "");
      return;
    case Opcode::kText:
      OnText(viewer, message.payload);
      return;
    default:
      ++counters_.protocol_errors;
      Deliver(viewer, SharedText(ErrorText("only text messages are understood")), 0);
      Close(viewer, CloseCode::kUnsupported, "only text messages are understood");
  }
}

void StreamHub::Impl::OnText(Viewer& viewer, const std::string& text) {
  if (!websocket::IsValidUtf8(text)) {
    ++counters_.protocol_errors;
    Deliver(viewer, SharedText(ErrorText("the text is not UTF-8")), 0);
    Close(viewer, CloseCode::kInvalidText, "not UTF-8");
    return;
  }
  auto parsed = ParseClientMessage(text);
  Channel& channel = *channels_[viewer.channel];
  if (!parsed) {
    ++counters_.protocol_errors;
    Deliver(viewer, SharedText(ErrorText(parsed.error().message)), 0);
    // A wrong field is a mistake of a program that speaks our language; the rest is noise.
    const bool garbage = parsed.error().field.empty();
    if (garbage) Close(viewer, CloseCode::kInvalidText, "not a message of this server");
    if (++viewer.refusals >= kRefusalsMax) Close(viewer, CloseCode::kPolicy, "too many errors");
    return;
  }
  if (const auto* ping = std::get_if<PingMessage>(&parsed.value())) {
    std::array<char, 128> pong;
    const int size = std::snprintf(pong.data(),
                                   pong.size(),
                                   "{\"type\":\"pong\",\"t\":%.17g,\"server_t\":%.6f}",
                                   ping->t,
                                   ServerSeconds(channel));
    Deliver(viewer, SharedText({pong.data(), static_cast<std::size_t>(size)}), 0);
  } else if (const auto* resume = std::get_if<ResumeMessage>(&parsed.value())) {
    viewer.catch_up = std::min(resume->since, channel.next_index);
    if (viewer.drained()) CatchUp(viewer);
  } else if (const auto* command = std::get_if<CommandMessage>(&parsed.value())) {
    if (!viewer.can_command) {
      Deliver(viewer,
              SharedText(AckText(*command,
                                 core::Error{core::ErrorCode::kForbidden,
                                             "You are watching; only the owner of the run commands "
                                             "it.",
                                             {}})),
              0);
    } else if (!channel.options.on_command) {
      Deliver(viewer,
              SharedText(AckText(
                  *command, core::Error{core::ErrorCode::kConflict, "The run has ended.", {}})),
              0);
    } else {
      channel.options.on_command(ViewerId{viewer.id()}, *command);
    }
  }
}

void StreamHub::Impl::RemoveBroken() {
  any_broken_ = false;
  for (auto it = viewers_.begin(); it != viewers_.end();) {
    Viewer* viewer = it->second.get();
    if (!viewer->broken) {
      ++it;
      continue;
    }
    if (viewer->channel < channels_.size()) {
      std::erase(channels_[viewer->channel]->viewers, viewer);
    }
    it = viewers_.erase(it);
    --counters_.viewers;
  }
}

StreamCounters StreamHub::Impl::counters() const {
  StreamCounters out;
  out.viewers_open = counters_.viewers;
  out.viewers_total = counters_.viewers_total;
  out.channels_open = counters_.channels;
  out.messages_sent = counters_.messages;
  out.bytes_sent = counters_.bytes;
  out.messages_dropped = counters_.dropped;
  out.inbox_refused = counters_.inbox_refused;
  out.protocol_errors = counters_.protocol_errors;
  return out;
}

StreamHub::StreamHub(StreamHubOptions options, const Clock& clock)
    : impl_(std::make_unique<Impl>(options, clock)) {}

StreamHub::~StreamHub() {
  Stop();
}

core::Status StreamHub::Start() {
  return impl_->Start();
}

void StreamHub::Stop() {
  impl_->Stop();
}

void StreamHub::OpenChannel(ChannelOptions options, std::string hello) {
  impl_->Post(
      [impl = impl_.get(), options = std::move(options), hello = std::move(hello)] {
        impl->OpenChannel(options, hello);
      },
      false);
}

void StreamHub::Publish(std::string_view run,
                        std::int64_t first_index,
                        std::span<const StreamRow> rows) {
  impl_->Post([impl = impl_.get(),
               run = std::string(run),
               first_index,
               rows = std::vector<StreamRow>(
                   rows.begin(), rows.end())] { impl->Publish(run, first_index, rows); },
              true);
}

void StreamHub::PublishText(std::string_view run, std::string text, std::string hello) {
  impl_->Post([impl = impl_.get(),
               run = std::string(run),
               text = std::move(text),
               hello = std::move(hello)] { impl->PublishText(run, text, hello); },
              false);
}

void StreamHub::Reply(ViewerId viewer, std::string text) {
  impl_->Post([impl = impl_.get(), viewer, text = std::move(text)] { impl->Reply(viewer, text); },
              true);
}

void StreamHub::CloseChannel(std::string_view run, std::string end_text, std::string hello) {
  impl_->Post([impl = impl_.get(),
               run = std::string(run),
               end_text = std::move(end_text),
               hello = std::move(hello)] { impl->CloseChannel(run, end_text, hello); },
              false);
}

void StreamHub::Adopt(UpgradedSocket socket, std::string_view run, bool can_command) {
  const int fd = socket.fd;
  const bool taken = impl_->Post(
      [impl = impl_.get(), socket = std::move(socket), run = std::string(run), can_command] {
        impl->Adopt(socket, run, can_command);
      },
      true);
  if (!taken) ::close(fd);
}

StreamCounters StreamHub::counters() const {
  return impl_->counters();
}

}  // namespace faultlab::server
