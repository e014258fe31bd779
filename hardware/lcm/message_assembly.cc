#include "hardware/lcm/message_assembly.h"

#include <algorithm>

#include "core/types/check.h"

namespace faultlab::hardware {

std::optional<LcmMessage> MessageAssembly::Add(const LcmSender& sender, const LcmPacket& fragment) {
  LAB_CHECK(fragment.message_bytes <= kLcmMessageBytesMax, fragment.message_bytes);
  Partial& partial = PartialOf(sender, fragment);
  if (!partial.open || fragment.message_bytes != partial.message_bytes ||
      fragment.count != partial.count || partial.pieces.contains(fragment.number)) {
    return std::nullopt;
  }
  if (partial.held_bytes + fragment.payload.size() > partial.message_bytes ||
      (fragment.number == 0 && !wanted_(fragment.channel))) {
    Close(partial);
    return std::nullopt;
  }
  if (fragment.number == 0) partial.channel = fragment.channel;
  partial.held_bytes += fragment.payload.size();
  partial.pieces[fragment.number] = {.offset = fragment.offset,
                                     .bytes = {fragment.payload.begin(), fragment.payload.end()}};
  if (partial.pieces.size() < partial.count) return std::nullopt;

  LcmMessage message{.channel = partial.channel, .bytes = {}};
  message.bytes.reserve(partial.held_bytes);
  bool gapless = partial.held_bytes == partial.message_bytes;
  for (const auto& [number, piece] : partial.pieces) {
    gapless = gapless && piece.offset == message.bytes.size();
    message.bytes.insert(message.bytes.end(), piece.bytes.begin(), piece.bytes.end());
  }
  Close(partial);
  if (!gapless) return std::nullopt;
  return message;
}

MessageAssembly::Partial& MessageAssembly::PartialOf(const LcmSender& sender,
                                                     const LcmPacket& fragment) {
  const auto found = std::ranges::find_if(partials_, [&](const Partial& partial) {
    return partial.sender == sender && partial.sequence == fragment.sequence;
  });
  if (found != partials_.end()) return *found;
  while (partials_.size() >= kPartialsMax || open_bytes_ + fragment.message_bytes > kBytesMax) {
    Close(partials_.front());
    partials_.pop_front();
  }
  open_bytes_ += fragment.message_bytes;
  partials_.push_back({.sender = sender,
                       .sequence = fragment.sequence,
                       .message_bytes = fragment.message_bytes,
                       .count = fragment.count,
                       .channel = {},
                       .pieces = {}});
  return partials_.back();
}

void MessageAssembly::Close(Partial& partial) {
  if (!partial.open) return;
  partial.open = false;
  partial.pieces.clear();
  open_bytes_ -= partial.message_bytes;
}

}  // namespace faultlab::hardware
