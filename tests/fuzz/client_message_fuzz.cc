#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "server/net/websocket.h"
#include "server/stream/client_message.h"

/// Bytes as a browser's text message, and the same bytes as the raw stream of its socket.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using faultlab::server::websocket::FrameReader;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto message = faultlab::server::ParseClientMessage(bytes);
  // A refusal says why; a command that passes has a positive value.
  if (!message.ok() && message.error().message.empty()) std::abort();
  if (message.ok()) {
    const auto* command = std::get_if<faultlab::server::CommandMessage>(&message.value());
    const bool set = command != nullptr && command->action == faultlab::server::ViewerAction::kSet;
    if (set && !(command->value > 0.0)) std::abort();
  }
  FrameReader reader(faultlab::server::kClientMessageBytesMax);
  // In pieces, as a network delivers.
  for (std::size_t at = 0; at < size; at += 7) {
    reader.Append(bytes.substr(at, 7));
    while (const auto frame = reader.Next()) {
      if (frame->payload.size() > faultlab::server::kClientMessageBytesMax) std::abort();
    }
  }
  return 0;
}
