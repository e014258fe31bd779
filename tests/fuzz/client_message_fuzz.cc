// Text that a browser sends over its socket: an accepted message is within its bounds, a refusal
// has a message.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "server/stream/client_message.h"

using namespace faultlab::server;  // NOLINT(google-build-using-namespace)

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto message =
      ParseClientMessage(std::string_view(reinterpret_cast<const char*>(data), size));
  if (!message.ok() && message.error().message.empty()) std::abort();
  if (message.ok()) {
    const auto* command = std::get_if<CommandMessage>(&message.value());
    const bool set = command != nullptr && command->action == ViewerAction::kSet;
    if (set && !(command->value > 0.0)) std::abort();
  }
  return 0;
}
