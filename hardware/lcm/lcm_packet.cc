#include "hardware/lcm/lcm_packet.h"

#include <algorithm>
#include <vector>

namespace faultlab::hardware {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kShortMagic = 0x4c433032;  // LC02
constexpr std::uint32_t kLongMagic = 0x4c433033;   // LC03
/// Channel, NUL and message in one UDP datagram of 65507 bytes behind a short header; behind a long
/// one.
constexpr std::size_t kShortBytesMax = 65'499;
constexpr std::size_t kFragmentBytesMax = 65'487;

/// Takes big-endian numbers from the front of a datagram; `failed` once it did not reach.
struct Reader {
  Bytes left;
  bool failed = false;

  std::uint32_t Take(std::size_t bytes) {
    if (left.size() < bytes) {
      failed = true;
      return 0;
    }
    std::uint32_t value = 0;
    for (const std::uint8_t byte : left.first(bytes)) value = value << 8 | byte;
    left = left.subspan(bytes);
    return value;
  }

  std::string_view TakeChannel() {
    const auto nul = std::ranges::find(left, 0);
    const auto size = static_cast<std::size_t>(nul - left.begin());
    if (nul == left.end() || size > kLcmChannelBytesMax) {
      failed = true;
      return {};
    }
    const std::string_view channel(reinterpret_cast<const char*>(left.data()), size);
    left = left.subspan(size + 1);
    return channel;
  }
};

void Put(std::vector<std::uint8_t>& out, std::uint32_t value, int bytes) {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) {
    out.push_back(static_cast<std::uint8_t>(value >> shift));
  }
}

void PutChannel(std::vector<std::uint8_t>& out, std::string_view channel) {
  out.insert(out.end(), channel.begin(), channel.end());
  out.push_back(0);
}

bool InBounds(const LcmPacket& fragment) {
  const std::uint64_t size = fragment.message_bytes;
  const std::uint64_t end = std::uint64_t{fragment.offset} + fragment.payload.size();
  if (size > kLcmMessageBytesMax || fragment.payload.empty() || end > size) return false;
  if (fragment.count > kLcmFragmentsMax || fragment.number >= fragment.count) return false;
  return fragment.count > 1 || fragment.payload.size() == size;
}

}  // namespace

std::optional<LcmPacket> ReadLcmPacket(Bytes datagram) {
  Reader reader{.left = datagram};
  const std::uint32_t magic = reader.Take(4);
  if (magic != kShortMagic && magic != kLongMagic) return std::nullopt;
  LcmPacket packet;
  packet.sequence = reader.Take(4);
  if (magic == kLongMagic) {
    packet.message_bytes = reader.Take(4);
    packet.offset = reader.Take(4);
    packet.number = static_cast<std::uint16_t>(reader.Take(2));
    packet.count = static_cast<std::uint16_t>(reader.Take(2));
  }
  if (packet.number == 0) packet.channel = reader.TakeChannel();
  if (reader.failed) return std::nullopt;
  packet.payload = reader.left;
  if (magic == kShortMagic) {
    if (packet.payload.size() > kShortBytesMax) return std::nullopt;
    packet.message_bytes = static_cast<std::uint32_t>(packet.payload.size());
  } else if (!InBounds(packet)) {
    return std::nullopt;
  }
  return packet;
}

bool WriteLcmPackets(std::uint32_t sequence,
                     std::string_view channel,
                     Bytes message,
                     const SendLcmPacket& send) {
  if (channel.size() > kLcmChannelBytesMax || channel.find('\0') != std::string_view::npos ||
      message.size() > kLcmMessageBytesMax) {
    return false;
  }
  std::vector<std::uint8_t> head;
  const std::size_t total = channel.size() + 1 + message.size();
  if (total <= kShortBytesMax) {
    Put(head, kShortMagic, 4);
    Put(head, sequence, 4);
    PutChannel(head, channel);
    send(head, message);
    return true;
  }
  const std::size_t count = (total + kFragmentBytesMax - 1) / kFragmentBytesMax;
  std::size_t offset = 0;
  for (std::size_t number = 0; number < count; ++number) {
    head.clear();
    Put(head, kLongMagic, 4);
    Put(head, sequence, 4);
    Put(head, static_cast<std::uint32_t>(message.size()), 4);
    Put(head, static_cast<std::uint32_t>(offset), 4);
    Put(head, static_cast<std::uint32_t>(number), 2);
    Put(head, static_cast<std::uint32_t>(count), 2);
    std::size_t room = kFragmentBytesMax;
    if (number == 0) {
      PutChannel(head, channel);
      room -= channel.size() + 1;
    }
    const std::size_t bytes = std::min(room, message.size() - offset);
    send(head, message.subspan(offset, bytes));
    offset += bytes;
  }
  return true;
}

}  // namespace faultlab::hardware
