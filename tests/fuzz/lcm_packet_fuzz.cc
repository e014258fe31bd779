// Any datagrams on the bus's port: every number of an accepted one is within its bound, and so are
// memory and messages.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "hardware/lcm/lcm_packet.h"
#include "hardware/lcm/message_assembly.h"

namespace {

using namespace faultlab::hardware;  // NOLINT(google-build-using-namespace)
using Bytes = std::span<const std::uint8_t>;

void Require(bool condition) {
  if (!condition) std::abort();
}

void CheckPacket(const LcmPacket& packet, Bytes datagram) {
  Require(packet.message_bytes <= kLcmMessageBytesMax);
  Require(packet.count >= 1 && packet.count <= kLcmFragmentsMax && packet.number < packet.count);
  Require(packet.channel.size() <= kLcmChannelBytesMax);
  Require(packet.payload.data() + packet.payload.size() == datagram.data() + datagram.size());
  Require(std::uint64_t{packet.offset} + packet.payload.size() <= packet.message_bytes);
  Require(packet.count > 1 || packet.payload.size() == packet.message_bytes);
}

}  // namespace

/// Datagrams in sequence: sender 1 byte, size 2 bytes, datagram.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  MessageAssembly assembly([](std::string_view channel) { return channel.starts_with("FAULT"); });
  Bytes left(data, size);
  while (left.size() >= 3) {
    const LcmSender sender{.address = 1, .port = left[0]};
    const std::size_t bytes = std::min<std::size_t>(left[1] << 8 | left[2], left.size() - 3);
    const Bytes datagram = left.subspan(3, bytes);
    left = left.subspan(3 + bytes);
    const auto packet = ReadLcmPacket(datagram);
    if (!packet) continue;
    CheckPacket(*packet, datagram);
    if (const auto message = assembly.Add(sender, *packet)) {
      Require(message->bytes.size() == packet->message_bytes);
      Require(message->channel.starts_with("FAULT"));
    }
    Require(assembly.partials() <= MessageAssembly::kPartialsMax);
    Require(assembly.open_bytes() <= MessageAssembly::kBytesMax);
  }
  return 0;
}
