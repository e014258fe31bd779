// The raw stream of a viewer's socket, in pieces as a network delivers them. The first byte
// determines their length.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "server/net/websocket.h"

using namespace faultlab::server;  // NOLINT(google-build-using-namespace)

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr std::size_t kPayloadMax = 300;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::size_t step = std::max<std::size_t>(1, data[0]);
  websocket::FrameReader reader(kPayloadMax);
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    reader.Append(bytes.substr(at, step));
    while (const auto frame = reader.Next()) {
      if (frame->payload.size() > kPayloadMax) std::abort();
    }
  }
  return 0;
}
