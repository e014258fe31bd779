#pragma once

// The one place where LCM types and ours meet.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/types/frame.h"
#include "core/types/sample.h"
#include "faultlab_msgs/estimates_t.hpp"
#include "faultlab_msgs/event_t.hpp"
#include "faultlab_msgs/layouts.hpp"
#include "faultlab_msgs/sample_t.hpp"
#include "hardware/lcm/message_layout.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// Of a sample and a message, or of two messages, that have these fields.
template <typename From, typename To>
void CopyReadings(const From& from, To& to) {
  to.index = from.index;
  to.t_s = from.t_s;
  to.uc_v = from.uc_v;
  to.um_v = from.um_v;
  to.ua_v = from.ua_v;
  to.ia_a = from.ia_a;
  to.n_rpm = from.n_rpm;
}

/// Fields of the run (rig, run, epoch, seq, sent_ns) are the caller's.
void Encode(const core::Sample& sample, faultlab_msgs::sample_t& out);
core::Sample Decode(const faultlab_msgs::sample_t& in);

void Encode(const core::Frame& frame, faultlab_msgs::estimates_t& out);

void Encode(const RigEvent& event, faultlab_msgs::event_t& out);
/// Nothing for a kind or component that this version does not know.
std::optional<RigEvent> Decode(const faultlab_msgs::event_t& in, const core::Bench& bench);

template <typename Message>
std::vector<std::uint8_t> ToBytes(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// LCM writes the type's hash before the fields.
inline constexpr std::size_t kMessageHashBytes = 8;

/// The one place that decodes: nothing when the bytes are not one whole message of this type. Every
/// length is known to lie inside the bytes before LCM's decoder, which believes them, sees one.
template <typename Message>
std::optional<Message> FromBytes(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kSizeMax = 1u << 24;
  if (bytes.size() < kMessageHashBytes || bytes.size() > kSizeMax) return std::nullopt;
  const std::size_t body = bytes.size() - kMessageHashBytes;
  if (WalkMessage(LayoutOf<Message>::kMessage, bytes.last(body)) != body) return std::nullopt;
  Message message;
  const int size = static_cast<int>(bytes.size());
  if (message.decode(bytes.data(), 0, size) != size) return std::nullopt;  // another type's hash
  return message;
}

}  // namespace faultlab::hardware
