#include "hardware/lcm/message_layout.h"

#include <algorithm>
#include <array>

namespace faultlab::hardware {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// A message with more fields is refused by deploy/cmake/LcmTypes.cmake.
constexpr std::size_t kFieldsMax = 64;
constexpr std::size_t kLengthBytes = 4;

std::optional<std::int32_t> ReadInt(Bytes bytes) {
  if (bytes.size() < kLengthBytes) return std::nullopt;
  std::uint32_t value = 0;
  for (const std::uint8_t byte : bytes.first(kLengthBytes)) value = value << 8 | byte;
  return static_cast<std::int32_t>(value);
}

std::optional<std::size_t> WalkString(Bytes bytes) {
  const std::optional<std::int32_t> length = ReadInt(bytes);
  if (!length || *length < 1) return std::nullopt;
  const Bytes rest = bytes.subspan(kLengthBytes);
  const auto size = static_cast<std::size_t>(*length);
  if (size > rest.size()) return std::nullopt;
  const Bytes text = rest.first(size);
  if (std::ranges::find(text, 0) != text.end() - 1) return std::nullopt;
  return kLengthBytes + size;
}

/// `times` elements of a field, one behind the other.
std::optional<std::size_t> WalkElements(const FieldLayout& field, std::size_t times, Bytes bytes) {
  if (field.bytes > 0) {
    if (times > bytes.size() / field.bytes) return std::nullopt;
    return times * field.bytes;
  }
  std::size_t at = 0;
  for (std::size_t i = 0; i < times; ++i) {
    const Bytes rest = bytes.subspan(at);
    const std::optional<std::size_t> size =
        field.message != nullptr ? WalkMessage(*field.message, rest) : WalkString(rest);
    if (!size) return std::nullopt;
    at += *size;
  }
  return at;
}

}  // namespace

std::optional<std::size_t> WalkMessage(const MessageLayout& layout, Bytes bytes) {
  std::array<std::size_t, kFieldsMax> offset{};
  std::size_t at = 0;
  for (std::size_t i = 0; i < layout.fields.size(); ++i) {
    const FieldLayout& field = layout.fields[i];
    offset[i] = at;
    std::size_t times = field.times;
    if (field.count_field >= 0) {
      const std::size_t count_at = offset[static_cast<std::size_t>(field.count_field)];
      const std::optional<std::int32_t> count = ReadInt(bytes.subspan(count_at));
      if (!count || *count < 0) return std::nullopt;
      times = static_cast<std::size_t>(*count);
    }
    const std::optional<std::size_t> size = WalkElements(field, times, bytes.subspan(at));
    if (!size) return std::nullopt;
    at += *size;
  }
  return at;
}

}  // namespace faultlab::hardware
