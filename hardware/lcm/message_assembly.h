#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hardware/lcm/lcm_packet.h"

namespace faultlab::hardware {

/// Of a datagram: IPv4 address and port. LCM counts its messages per sender.
struct LcmSender {
  std::uint32_t address = 0;
  std::uint16_t port = 0;
  bool operator==(const LcmSender&) const = default;
};

struct LcmMessage {
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

/// Puts the fragments of messages together, in whatever order they arrive. A message is known by
/// its sender and sequence number.
///   doubled fragment                            the first one counts
///   size or count not those of the first one    the fragment is refused
///   overlap or hole between fragments           the message is refused
///   channel not wanted                          the message is refused
/// Memory grows with what arrived, not with what a datagram says. A message is begun at the cost of
/// the oldest ones when its size, or one more, is beyond a bound below. Anyone on the network can
/// so push out messages that are half there: the bus promises no delivery.
class MessageAssembly {
 public:
  static constexpr std::size_t kPartialsMax = 64;
  static constexpr std::size_t kBytesMax = 16 * kLcmMessageBytesMax;
  using Wanted = std::function<bool(std::string_view channel)>;

  explicit MessageAssembly(Wanted wanted) : wanted_(std::move(wanted)) {}

  /// @param fragment  as ReadLcmPacket gave it
  /// @returns the message of which this was the last missing fragment
  std::optional<LcmMessage> Add(const LcmSender& sender, const LcmPacket& fragment);

  std::size_t partials() const { return partials_.size(); }
  /// Sizes of the messages that are open: not less than what is held of them.
  std::size_t open_bytes() const { return open_bytes_; }

 private:
  struct Piece {
    std::uint32_t offset;
    std::vector<std::uint8_t> bytes;
  };
  struct Partial {
    LcmSender sender;
    std::uint32_t sequence;
    std::uint32_t message_bytes;
    std::uint16_t count;
    std::string channel;
    std::map<std::uint16_t, Piece> pieces;
    std::size_t held_bytes = 0;
    bool open = true;  ///< not once it is complete or refused: what follows of it is ignored
  };

  Partial& PartialOf(const LcmSender& sender, const LcmPacket& fragment);
  void Close(Partial& partial);

  const Wanted wanted_;
  std::list<Partial> partials_;  ///< oldest first
  std::size_t open_bytes_ = 0;
};

}  // namespace faultlab::hardware
