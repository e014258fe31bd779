#include "server/stream/hub_loop.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <set>
#include <utility>

namespace faultlab::server {
namespace {

using websocket::CloseCode;
using websocket::Opcode;

constexpr std::uint64_t kWakeUp = 0;  ///< epoll data of the inbox; viewers count from 1
constexpr int kTickMilliseconds = 250;
constexpr int kCatchUpRows = 50;           ///< per frame
constexpr int kCatchUpFramesPerTurn = 16;  ///< then the other viewers have their turn
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

}  // namespace

core::Status HubLoop::Start() {
  epoll_fd_ = epoll_create1(EPOLL_CLOEXEC);
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = kWakeUp;
  if (epoll_fd_ < 0 || !inbox_.Open() ||
      epoll_ctl(epoll_fd_, EPOLL_CTL_ADD, inbox_.fd(), &event) != 0) {
    return core::Error{core::ErrorCode::kUnavailable,
                       std::string("cannot watch sockets: ") + std::strerror(errno),
                       {},
                       "internal"};
  }
  thread_ = std::thread([this] { Loop(); });
  return core::Done{};
}

void HubLoop::Stop() {
  if (!thread_.joinable()) return;
  Post(
      [this] {
        for (auto& [id, viewer] : viewers_) {
          Close(*viewer, CloseCode::kGoingAway, "the server stops");
        }
        inbox_.Close();
      },
      false);
  thread_.join();
  viewers_.clear();
  counters_.viewers = 0;
  ::close(epoll_fd_);
}

bool HubLoop::Post(std::function<void()> work, bool droppable) {
  const HubInbox::Posted posted = inbox_.Post(std::move(work), droppable);
  if (posted == HubInbox::Posted::kFull) ++counters_.inbox_refused;
  return posted == HubInbox::Posted::kYes;
}

void HubLoop::Loop() {
  std::array<epoll_event, 256> events;
  while (!inbox_.closed()) {
    const int count =
        epoll_wait(epoll_fd_, events.data(), static_cast<int>(events.size()), kTickMilliseconds);
    for (int i = 0; i < count; ++i) {
      const epoll_event& event = events[static_cast<std::size_t>(i)];
      if (event.data.u64 == kWakeUp) {
        inbox_.RunAll();
      } else {
        OnEvent(event.data.u64, event.events);
      }
    }
    if (any_broken_) RemoveBroken();
    Tick();
  }
}

void HubLoop::Tick() {
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
    if (!channel->open || !channel->ended) continue;
    const bool unseen = channel->options.brief && channel->viewers.empty();
    if (!unseen && now - *channel->ended < options_.linger) continue;
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

HubLoop::Channel* HubLoop::FindChannel(const std::string& run) {
  const auto found = channel_by_run_.find(run);
  return found == channel_by_run_.end() ? nullptr : channels_[found->second].get();
}

void HubLoop::OpenChannel(ChannelOptions options, std::string hello) {
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

void HubLoop::Publish(const std::string& run,
                      std::int64_t first_index,
                      std::vector<StreamRow> rows) {
  Channel* channel = FindChannel(run);
  if (channel == nullptr || rows.empty()) return;
  constexpr std::size_t kBriefRows = 500;
  channel->history.Append(
      first_index, rows, channel->options.brief ? kBriefRows : options_.history_rows_max);
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

void HubLoop::PublishText(const std::string& run, std::string_view text, std::string hello) {
  Channel* channel = FindChannel(run);
  if (channel == nullptr) return;
  if (!hello.empty()) channel->hello = std::move(hello);
  if (channel->viewers.empty() || text.empty()) return;
  const SharedBytes bytes = SharedText(text);
  for (Viewer* viewer : channel->viewers) Deliver(*viewer, bytes, 0);
}

void HubLoop::Reply(ViewerId viewer, std::string_view text) {
  const auto found = viewers_.find(static_cast<std::uint64_t>(viewer));
  if (found != viewers_.end()) DeliverText(*found->second, text);
}

void HubLoop::CloseChannel(const std::string& run, std::string_view end_text, std::string hello) {
  Channel* channel = FindChannel(run);
  if (channel == nullptr) return;
  channel->ended = clock_.Monotonic();  // before any viewer is told
  channel->options.on_command = nullptr;
  PublishText(run, end_text, std::move(hello));
}

void HubLoop::SendHello(Viewer& viewer, const Channel& channel) {
  if (!channel.options.signals) {
    DeliverText(viewer, channel.hello);
    return;
  }
  static const std::string lists = ChannelListJson();
  std::string text = "{\"type\":\"hello\",";
  text.append(channel.hello);
  text.append(",\"first_index\":").append(std::to_string(channel.history.first()));
  text.append(",\"next_index\":").append(std::to_string(channel.history.next()));
  text.append(",").append(lists);
  text.append(viewer.can_command ? ",\"can_command\":true}" : ",\"can_command\":false}");
  DeliverText(viewer, text);
}

void HubLoop::Refuse(int fd, std::string_view why) {
  const std::string bytes = websocket::EncodeClose(CloseCode::kTryAgainLater, why);
  if (::send(fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
    // There is no viewer to tell.
  }
  ::close(fd);
}

void HubLoop::Adopt(UpgradedSocket socket,
                    const std::string& run,
                    const ViewerOwner& owner,
                    bool can_command) {
  if (viewers_.size() >= options_.viewers_max) return Refuse(socket.fd, "too many viewers");
  const auto own = of_caller_.find(owner.caller);
  if (own != of_caller_.end() && own->second >= options_.viewers_per_caller_max) {
    return Refuse(socket.fd, "too many windows of yours are open");
  }
  // The other half is reserved for viewers with an account, so that guests cannot take it.
  if (owner.guest() && guests_ >= (options_.viewers_max + 1) / 2) {
    return Refuse(socket.fd, "too many guests are watching");
  }
  const int on = 1;
  setsockopt(socket.fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  setsockopt(socket.fd,
             SOL_SOCKET,
             SO_SNDBUF,
             &options_.socket_send_buffer_bytes,
             sizeof options_.socket_send_buffer_bytes);
  const std::uint64_t id = next_viewer_++;
  auto owned =
      std::make_unique<Viewer>(id, socket.fd, options_.ring_messages, options_.text_bytes_max);
  Viewer& viewer = *owned;
  epoll_event event{};
  event.events = EPOLLIN | EPOLLRDHUP;
  event.data.u64 = id;
  if (epoll_ctl(epoll_fd_, EPOLL_CTL_ADD, socket.fd, &event) != 0) return;
  viewer.last_heard = viewer.last_ping = viewer.rate_window = clock_.Monotonic();
  viewer.owner = owner;
  ++of_caller_[owner.caller];
  if (owner.guest()) ++guests_;
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

void HubLoop::CloseOf(const std::function<bool(const ViewerOwner&)>& which) {
  for (auto& [id, viewer] : viewers_) {
    if (!which(viewer->owner)) continue;
    viewer->can_command = false;
    Close(*viewer, CloseCode::kPolicy, "you are signed out here");
  }
}

std::vector<ViewerOwner> HubLoop::Owners() const {
  std::set<ViewerOwner> known;
  for (const auto& [id, viewer] : viewers_) known.insert(viewer->owner);
  return {known.begin(), known.end()};
}

void HubLoop::Watch(Viewer& viewer, bool for_write) {
  if (viewer.waits_for_write == for_write) return;
  epoll_event event{};
  event.events = EPOLLIN | EPOLLRDHUP | (for_write ? EPOLLOUT : 0U);
  event.data.u64 = viewer.id();
  epoll_ctl(epoll_fd_, EPOLL_CTL_MOD, viewer.fd(), &event);
  viewer.waits_for_write = for_write;
}

void HubLoop::Deliver(Viewer& viewer, const SharedBytes& bytes, int samples) {
  if (viewer.broken || viewer.close_by) return;
  counters_.messages.fetch_add(1, std::memory_order_relaxed);
  counters_.bytes.fetch_add(bytes->size(), std::memory_order_relaxed);
  const std::uint64_t dropped = viewer.dropped_messages();
  After(viewer, viewer.Send(bytes, samples));
  counters_.dropped += viewer.dropped_messages() - dropped;
}

void HubLoop::DeliverText(Viewer& viewer, std::string_view text) {
  Deliver(viewer, SharedText(text), 0);
}

void HubLoop::After(Viewer& viewer, Viewer::Sent sent) {
  if (sent == Viewer::Sent::kBroken || (sent == Viewer::Sent::kFull && viewer.close_by)) {
    viewer.broken = any_broken_ = true;
  } else if (sent == Viewer::Sent::kFull) {
    viewer.Forget();
    Close(viewer, CloseCode::kTryAgainLater, "messages were not read");
  } else if (sent == Viewer::Sent::kQueued) {
    Watch(viewer, true);
  }
}

void HubLoop::CatchUp(Viewer& viewer) {
  Channel& channel = *channels_[viewer.channel];
  for (int turn = 0; turn < kCatchUpFramesPerTurn && viewer.drained() && !viewer.broken; ++turn) {
    const std::int64_t from = std::max(viewer.catch_up, channel.history.first());
    if (from >= channel.history.next()) {
      viewer.catch_up = -1;
      return;
    }
    const std::span<const StreamRow> rows = channel.history.From(from, kCatchUpRows);
    const auto count = static_cast<std::int64_t>(rows.size());
    viewer.catch_up = from + count;
    Deliver(viewer,
            Shared(websocket::EncodeFrame(Opcode::kBinary,
                                          EncodeFrameMessage(rows, from, ServerSeconds(channel)))),
            static_cast<int>(count));
  }
  Watch(viewer, true);
}

void HubLoop::Close(Viewer& viewer, CloseCode code, std::string_view reason) {
  if (viewer.close_by || viewer.broken) return;
  viewer.close_by = clock_.Monotonic() + kClosePatience;
  After(viewer, viewer.Send(Shared(websocket::EncodeClose(code, reason)), 0));
  if (viewer.drained()) ::shutdown(viewer.fd(), SHUT_WR);
}

void HubLoop::OnEvent(std::uint64_t id, std::uint32_t events) {
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
        DeliverText(viewer, "{\"type\":\"dropped\",\"samples\":" + std::to_string(dropped) + "}");
      }
      if (viewer.catch_up >= 0 && !viewer.close_by) CatchUp(viewer);
    }
  }
  if ((events & (EPOLLIN | EPOLLRDHUP | EPOLLERR | EPOLLHUP)) != 0) OnReadable(viewer);
}

void HubLoop::OnReadable(Viewer& viewer) {
  std::array<char, 4096> bytes;
  const ssize_t got = ::recv(viewer.fd(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (got <= 0) {
    viewer.broken = any_broken_ = true;
    return;
  }
  if (viewer.close_by) return;  // input is discarded until the peer closes
  viewer.last_heard = clock_.Monotonic();
  viewer.reader.Append({bytes.data(), static_cast<std::size_t>(got)});
  while (!viewer.broken && !viewer.close_by) {
    const auto message = viewer.reader.Next();
    if (!message) break;
    OnMessage(viewer, *message);
  }
  if (const auto error = viewer.reader.error(); error && !viewer.close_by) {
    Reject(viewer, *error, "the WebSocket protocol was broken", "protocol error");
  }
}

void HubLoop::RemoveBroken() {
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
    const auto own = of_caller_.find(viewer->owner.caller);
    if (--own->second == 0) of_caller_.erase(own);
    if (viewer->owner.guest()) --guests_;
    it = viewers_.erase(it);
    --counters_.viewers;
  }
}

StreamCounters HubLoop::counters() const {
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

}  // namespace faultlab::server
