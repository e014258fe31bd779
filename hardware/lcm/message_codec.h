#pragma once

// The one place where LCM types and ours meet.
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/types/frame.h"
#include "core/types/sample.h"
#include "faultlab_msgs/estimates_t.hpp"
#include "faultlab_msgs/event_t.hpp"
#include "faultlab_msgs/sample_t.hpp"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// Fields of the run (rig, run, epoch, seq, sent_ns) are the caller's.
void Encode(const core::Sample& sample, faultlab_msgs::sample_t& out);
core::Sample Decode(const faultlab_msgs::sample_t& in);

void Encode(const core::Frame& frame, faultlab_msgs::estimates_t& out);

void Encode(const RigEvent& event, faultlab_msgs::event_t& out);
/// Nothing for a kind or component that this version does not know.
std::optional<RigEvent> Decode(const faultlab_msgs::event_t& in);

template <typename Message>
std::vector<std::uint8_t> ToBytes(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// Nothing when the bytes are not one whole message of this type. Without a checked mac only for
/// types without arrays of variable length: their decoders allocate what the bytes say.
template <typename Message>
std::optional<Message> FromBytes(const void* data, std::uint64_t size) {
  Message message;
  constexpr std::uint64_t kSizeMax = 1u << 24;
  try {
    if (size <= kSizeMax &&
        message.decode(data, 0, static_cast<int>(size)) == static_cast<int>(size)) {
      return message;
    }
  } catch (const std::length_error&) {
    // A string of no length: LCM's decoder takes 1 from it.
  }
  return std::nullopt;
}

}  // namespace faultlab::hardware
