#include "hardware/lcm/lcm_event_file.h"

#include <algorithm>
#include <array>
#include <utility>

namespace faultlab::hardware {
namespace {

constexpr std::uint32_t kSync = 0xeda1da01;
/// Of liblcm's own reader.
constexpr std::int64_t kChannelBytesMax = 999;
/// Of a message that is decoded (message_codec.h).
constexpr std::int64_t kDataBytesMax = 1 << 24;

std::uint64_t ReadUnsigned(std::istream& in, int bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value = value << 8 | static_cast<std::uint8_t>(in.get());
  return value;
}

/// Memory grows with what the file holds, not with what it says.
template <typename Bytes>
bool ReadBytes(std::istream& in, std::int64_t size, Bytes& out) {
  std::array<char, 4096> piece;
  while (size > 0) {
    in.read(piece.data(), std::min<std::int64_t>(size, piece.size()));
    if (in.gcount() == 0) return false;
    out.insert(out.end(), piece.begin(), piece.begin() + in.gcount());
    size -= in.gcount();
  }
  return true;
}

void AppendUnsigned(std::uint64_t value, int bytes, std::string& out) {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) {
    out.push_back(static_cast<char>(value >> shift & 0xff));
  }
}

}  // namespace

void AppendLcmEvent(const LcmEvent& event, std::string& out) {
  AppendUnsigned(kSync, 4, out);
  AppendUnsigned(static_cast<std::uint64_t>(event.number), 8, out);
  AppendUnsigned(static_cast<std::uint64_t>(event.timestamp_us), 8, out);
  AppendUnsigned(event.channel.size(), 4, out);
  AppendUnsigned(event.data.size(), 4, out);
  out += event.channel;
  out.append(event.data.begin(), event.data.end());
}

bool LcmEventFile::FindSync() {
  std::uint32_t word = 0;
  while (word != kSync) {
    const int byte = in_.get();
    if (byte < 0) return false;
    word = word << 8 | static_cast<std::uint32_t>(byte);
  }
  return true;
}

core::Result<std::optional<LcmEvent>> LcmEventFile::Next() {
  if (!FindSync()) return std::optional<LcmEvent>();
  LcmEvent event;
  event.number = static_cast<std::int64_t>(ReadUnsigned(in_, 8));
  event.timestamp_us = static_cast<std::int64_t>(ReadUnsigned(in_, 8));
  const auto channel_bytes = static_cast<std::int32_t>(ReadUnsigned(in_, 4));
  const auto data_bytes = static_cast<std::int32_t>(ReadUnsigned(in_, 4));
  if (!in_) return std::optional<LcmEvent>();
  if (channel_bytes < 1 || channel_bytes > kChannelBytesMax || data_bytes < 0 ||
      data_bytes > kDataBytesMax) {
    return core::Error{.code = core::ErrorCode::kInvalid,
                       .message = "event " + std::to_string(event.number) + " has a channel of " +
                                  std::to_string(channel_bytes) + " bytes and data of " +
                                  std::to_string(data_bytes) + " bytes: the log is damaged there",
                       .field = {}};
  }
  if (!ReadBytes(in_, channel_bytes, event.channel) || !ReadBytes(in_, data_bytes, event.data)) {
    return std::optional<LcmEvent>();
  }
  return std::optional<LcmEvent>(std::move(event));
}

}  // namespace faultlab::hardware
