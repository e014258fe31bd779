#include "server/stream/stream_hub.h"

#include <unistd.h>

#include <chrono>
#include <future>
#include <utility>
#include <vector>

#include "server/stream/hub_loop.h"

namespace faultlab::server {

StreamHub::StreamHub(StreamHubOptions options, const Clock& clock)
    : loop_(std::make_unique<HubLoop>(options, clock)) {}

StreamHub::~StreamHub() {
  Stop();
}

core::Status StreamHub::Start() {
  return loop_->Start();
}

void StreamHub::Stop() {
  loop_->Stop();
}

void StreamHub::OpenChannel(ChannelOptions options, std::string hello) {
  loop_->Post(
      [loop = loop_.get(), options = std::move(options), hello = std::move(hello)] {
        loop->OpenChannel(options, hello);
      },
      false);
}

void StreamHub::Publish(std::string_view run,
                        std::int64_t first_index,
                        std::span<const StreamRow> rows) {
  loop_->Post([loop = loop_.get(),
               run = std::string(run),
               first_index,
               rows = std::vector<StreamRow>(
                   rows.begin(), rows.end())] { loop->Publish(run, first_index, rows); },
              true);
}

void StreamHub::PublishText(std::string_view run, std::string text, std::string hello) {
  loop_->Post([loop = loop_.get(),
               run = std::string(run),
               text = std::move(text),
               hello = std::move(hello)] { loop->PublishText(run, text, hello); },
              false);
}

void StreamHub::Reply(ViewerId viewer, std::string text) {
  loop_->Post([loop = loop_.get(), viewer, text = std::move(text)] { loop->Reply(viewer, text); },
              true);
}

void StreamHub::CloseChannel(std::string_view run, std::string end_text, std::string hello) {
  loop_->Post([loop = loop_.get(),
               run = std::string(run),
               end_text = std::move(end_text),
               hello = std::move(hello)] { loop->CloseChannel(run, end_text, hello); },
              false);
}

void StreamHub::Adopt(UpgradedSocket socket,
                      std::string_view run,
                      ViewerOwner owner,
                      bool can_command) {
  const int fd = socket.fd;
  const bool taken = loop_->Post([loop = loop_.get(),
                                  socket = std::move(socket),
                                  run = std::string(run),
                                  owner = std::move(owner),
                                  can_command] { loop->Adopt(socket, run, owner, can_command); },
                                 true);
  if (!taken) ::close(fd);
}

void StreamHub::CloseOf(std::function<bool(const ViewerOwner&)> which) {
  loop_->Post([loop = loop_.get(), which = std::move(which)] { loop->CloseOf(which); }, false);
}

std::vector<ViewerOwner> StreamHub::Owners() {
  auto owners = std::make_shared<std::promise<std::vector<ViewerOwner>>>();
  auto known = owners->get_future();
  const bool asked =
      loop_->Post([loop = loop_.get(), owners] { owners->set_value(loop->Owners()); }, false);
  constexpr std::chrono::seconds kPatience{2};  // a hub that is stopping may never execute it
  if (!asked || known.wait_for(kPatience) != std::future_status::ready) return {};
  return known.get();
}

StreamCounters StreamHub::counters() const {
  return loop_->counters();
}

}  // namespace faultlab::server
