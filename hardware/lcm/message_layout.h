#pragma once

// Where the lengths lie in the bytes of an LCM message. lcm-gen's decoders believe the lengths that
// they read (a string of -2^31 bytes crashes them), so no message is decoded before WalkMessage has
// found each length inside its bytes. The layouts are generated from types/*.lcm
// (deploy/cmake/LcmTypes.cmake): a type without one does not compile.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace faultlab::hardware {

struct MessageLayout;

/// One field: a number, a string or a message, once or in an array. In the order of the bytes,
/// which are big-endian and without gaps.
struct FieldLayout {
  const char* name;
  std::size_t bytes = 0;                   ///< of a number; 0 = a string or a message
  const MessageLayout* message = nullptr;  ///< of a message
  std::size_t times = 1;                   ///< of an array of fixed length
  int count_field = -1;                    ///< index of the int32_t that says how many; -1 = none
};

struct MessageLayout {
  const char* name;
  std::span<const FieldLayout> fields;
};

/// LayoutOf<Message>::kMessage, for every type in types/.
template <typename Message>
struct LayoutOf;

template <typename... Messages>
struct MessageList {};

/// Follows the lengths through the fields of a message, without the hash before them.
///   string: length 1 to what is left, a NUL at its end and nowhere else
///   array:  count 0 or more, all elements within what is left
/// @returns the bytes that the message takes; nothing when a length points outside of `bytes`.
/// No allocation; at most one step a byte.
std::optional<std::size_t> WalkMessage(const MessageLayout& layout,
                                       std::span<const std::uint8_t> bytes);

}  // namespace faultlab::hardware
