#include "server/stream/stream_hub.h"

#include <unistd.h>

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

void StreamHub::Adopt(UpgradedSocket socket, std::string_view run, bool can_command) {
  const int fd = socket.fd;
  const bool taken = loop_->Post(
      [loop = loop_.get(), socket = std::move(socket), run = std::string(run), can_command] {
        loop->Adopt(socket, run, can_command);
      },
      true);
  if (!taken) ::close(fd);
}

StreamCounters StreamHub::counters() const {
  return loop_->counters();
}

}  // namespace faultlab::server
