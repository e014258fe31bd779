#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/signals/random.h"
#include "hardware/lcm/message_codec.h"
#include "hardware/lcm/message_layout.h"

namespace faultlab::hardware {

/// A message as bytes, made from its layout alone, and the positions of its lengths.
struct WireMessage {
  std::vector<std::uint8_t> bytes;
  std::vector<std::size_t> strings;  ///< offsets of the lengths of strings
  std::vector<std::size_t> counts;   ///< offsets of the counts of arrays
};

/// Lengths that no message has, of any size.
inline constexpr std::int32_t kBadLengths[] = {std::numeric_limits<std::int32_t>::min(),
                                               std::numeric_limits<std::int32_t>::min() + 1,
                                               -1000,
                                               -2,
                                               -1,
                                               1 << 24,
                                               std::numeric_limits<std::int32_t>::max() - 1,
                                               std::numeric_limits<std::int32_t>::max()};

inline void PutInt(std::vector<std::uint8_t>& bytes, std::size_t at, std::int32_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(bits >> (24 - 8 * i));
  }
}

/// Appends one body: short strings, up to 3 elements an array, any numbers.
inline void AppendBody(const MessageLayout& layout, core::Random& random, WireMessage& out) {
  std::vector<std::size_t> count(layout.fields.size(), 0);
  for (const FieldLayout& field : layout.fields) {
    if (field.count_field >= 0) {
      count[static_cast<std::size_t>(field.count_field)] = 1 + random.Below(4);
    }
  }
  for (std::size_t i = 0; i < layout.fields.size(); ++i) {
    const FieldLayout& field = layout.fields[i];
    if (count[i] > 0) {  // it is the number of elements of an array
      out.counts.push_back(out.bytes.size());
      out.bytes.resize(out.bytes.size() + 4);
      PutInt(out.bytes, out.bytes.size() - 4, static_cast<std::int32_t>(count[i] - 1));
      continue;
    }
    const std::size_t times = field.count_field < 0
                                  ? field.times
                                  : count[static_cast<std::size_t>(field.count_field)] - 1;
    for (std::size_t n = 0; n < times; ++n) {
      if (field.message != nullptr) {
        AppendBody(*field.message, random, out);
      } else if (field.bytes > 0) {
        for (std::size_t byte = 0; byte < field.bytes; ++byte) {
          out.bytes.push_back(static_cast<std::uint8_t>(random.Below(256)));
        }
      } else {
        const std::size_t letters = random.Below(20);
        out.strings.push_back(out.bytes.size());
        out.bytes.resize(out.bytes.size() + 4);
        PutInt(out.bytes, out.bytes.size() - 4, static_cast<std::int32_t>(letters + 1));
        for (std::size_t letter = 0; letter < letters; ++letter) {
          out.bytes.push_back(static_cast<std::uint8_t>('a' + random.Below(26)));
        }
        out.bytes.push_back(0);
      }
    }
  }
}

/// A complete message of this type, with its hash.
template <typename Message>
WireMessage MakeWireMessage(core::Random& random) {
  WireMessage out;
  const auto hash = static_cast<std::uint64_t>(Message::getHash());
  for (int shift = 56; shift >= 0; shift -= 8) {
    out.bytes.push_back(static_cast<std::uint8_t>(hash >> shift));
  }
  AppendBody(LayoutOf<Message>::kMessage, random, out);
  return out;
}

}  // namespace faultlab::hardware
