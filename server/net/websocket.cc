#include "server/net/websocket.h"

#include <algorithm>
#include <array>
#include <bit>

namespace faultlab::server::websocket {
namespace {

constexpr std::string_view kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
constexpr std::string_view kBase64 =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::size_t kControlBytesMax = 125;

using Digest = std::array<std::uint8_t, 20>;

/// FIPS 180-4. The WebSocket handshake is the only place that wants SHA-1, and it guards nothing.
Digest Sha1(std::string_view text) {
  std::string padded(text);
  padded.push_back(static_cast<char>(0x80));
  while (padded.size() % 64 != 56) padded.push_back('\0');
  const std::uint64_t bits = text.size() * 8;
  for (int shift = 56; shift >= 0; shift -= 8) {
    padded.push_back(static_cast<char>(bits >> shift));
  }
  std::array<std::uint32_t, 5> h = {0x67452301, 0xEFCDAB89, 0x98BADCFE, 0x10325476, 0xC3D2E1F0};
  for (std::size_t block = 0; block < padded.size(); block += 64) {
    std::array<std::uint32_t, 80> w{};
    for (std::size_t i = 0; i < 16; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        w[i] = (w[i] << 8) | static_cast<std::uint8_t>(padded[block + 4 * i + j]);
      }
    }
    for (std::size_t i = 16; i < 80; ++i) {
      w[i] = std::rotl(w[i - 3] ^ w[i - 8] ^ w[i - 14] ^ w[i - 16], 1);
    }
    auto [a, b, c, d, e] = h;
    for (std::size_t i = 0; i < 80; ++i) {
      std::uint32_t f = 0;
      std::uint32_t k = 0;
      if (i < 20) {
        f = (b & c) | (~b & d);
        k = 0x5A827999;
      } else if (i < 40) {
        f = b ^ c ^ d;
        k = 0x6ED9EBA1;
      } else if (i < 60) {
        f = (b & c) | (b & d) | (c & d);
        k = 0x8F1BBCDC;
      } else {
        f = b ^ c ^ d;
        k = 0xCA62C1D6;
      }
      const std::uint32_t next = std::rotl(a, 5) + f + e + k + w[i];
      e = d;
      d = c;
      c = std::rotl(b, 30);
      b = a;
      a = next;
    }
    h[0] += a;
    h[1] += b;
    h[2] += c;
    h[3] += d;
    h[4] += e;
  }
  Digest digest{};
  for (std::size_t i = 0; i < 20; ++i) {
    digest[i] = static_cast<std::uint8_t>(h[i / 4] >> (24 - 8 * (i % 4)));
  }
  return digest;
}

std::string Base64(const Digest& bytes) {
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t j = 0; j < 3; ++j) group = (group << 8) | (j < left ? bytes[i + j] : 0U);
    for (std::size_t j = 0; j < 4; ++j) {
      out.push_back(j <= left ? kBase64[(group >> (18 - 6 * j)) & 63] : '=');
    }
  }
  return out;
}

bool IsControl(Opcode opcode) {
  return static_cast<std::uint8_t>(opcode) >= 8;
}

bool IsKnown(std::uint8_t opcode) {
  return opcode <= 2 || (opcode >= 8 && opcode <= 10);
}

}  // namespace

std::string AcceptKey(std::string_view key) {
  return Base64(Sha1(std::string(key).append(kGuid)));
}

bool IsValidKey(std::string_view key) {
  if (key.size() != 24 || key[22] != '=' || key[23] != '=') return false;
  return key.substr(0, 22).find_first_not_of(kBase64) == std::string_view::npos;
}

std::string EncodeFrame(Opcode opcode, std::string_view payload) {
  std::string frame;
  frame.reserve(payload.size() + 10);
  frame.push_back(static_cast<char>(0x80 | static_cast<std::uint8_t>(opcode)));
  const std::uint64_t size = payload.size();
  int length_bytes = 0;
  if (size < 126) {
    frame.push_back(static_cast<char>(size));
  } else if (size <= 0xFFFF) {
    frame.push_back(126);
    length_bytes = 2;
  } else {
    frame.push_back(127);
    length_bytes = 8;
  }
  for (int i = length_bytes - 1; i >= 0; --i) frame.push_back(static_cast<char>(size >> (8 * i)));
  frame.append(payload);
  return frame;
}

std::string EncodeClose(CloseCode code, std::string_view reason) {
  const auto number = static_cast<std::uint16_t>(code);
  std::string payload;
  payload.push_back(static_cast<char>(number >> 8));
  payload.push_back(static_cast<char>(number & 0xFF));
  payload.append(reason.substr(0, kControlBytesMax - 2));
  return EncodeFrame(Opcode::kClose, payload);
}

bool IsValidUtf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    if (lead < 0x80) {
      ++i;
      continue;
    }
    const int more = lead >= 0xF0 ? 3 : lead >= 0xE0 ? 2 : lead >= 0xC0 ? 1 : -1;
    if (more < 0 || lead > 0xF4 || i + static_cast<std::size_t>(more) >= text.size()) return false;
    std::uint32_t point = lead & (0x3FU >> more);
    for (int j = 1; j <= more; ++j) {
      const auto next = static_cast<unsigned char>(text[i + static_cast<std::size_t>(j)]);
      if ((next & 0xC0) != 0x80) return false;
      point = (point << 6) | (next & 0x3FU);
    }
    constexpr std::array<std::uint32_t, 4> kSmallest = {0, 0x80, 0x800, 0x10000};
    const bool surrogate = point >= 0xD800 && point <= 0xDFFF;
    if (point < kSmallest[static_cast<std::size_t>(more)] || point > 0x10FFFF || surrogate) {
      return false;
    }
    i += static_cast<std::size_t>(more) + 1;
  }
  return true;
}

void FrameReader::Append(std::string_view bytes) {
  if (error_) return;
  if (consumed_ > 0) {
    buffer_.erase(0, consumed_);
    consumed_ = 0;
  }
  buffer_.append(bytes);
}

std::optional<FrameReader::Message> FrameReader::Fail(CloseCode code) {
  error_ = code;
  buffer_ = {};
  fragments_ = {};
  consumed_ = 0;
  return std::nullopt;
}

std::optional<FrameReader::Message> FrameReader::Next() {
  while (!error_) {
    const std::string_view bytes = std::string_view(buffer_).substr(consumed_);
    const auto at = [&bytes](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
    if (bytes.size() < 2) break;
    const bool fin = (at(0) & 0x80) != 0;
    const std::uint8_t code = at(0) & 0x0F;
    if ((at(0) & 0x70) != 0 || !IsKnown(code) || (at(1) & 0x80) == 0) {
      return Fail(CloseCode::kProtocolError);
    }
    const auto opcode = static_cast<Opcode>(code);
    std::uint64_t length = at(1) & 0x7F;
    if (IsControl(opcode) && (!fin || length > kControlBytesMax)) {
      return Fail(CloseCode::kProtocolError);
    }
    const std::size_t length_bytes = length == 126 ? 2 : length == 127 ? 8 : 0;
    const std::size_t header = 2 + length_bytes + 4;
    if (bytes.size() < 2 + length_bytes) break;
    if (length_bytes > 0) {
      length = 0;
      for (std::size_t i = 0; i < length_bytes; ++i) length = (length << 8) | at(2 + i);
    }
    // Judged before a byte of the payload is waited for: a stated 2^63 costs nothing.
    if (length > message_bytes_max_ || fragments_.size() + length > message_bytes_max_) {
      return Fail(CloseCode::kTooBig);
    }
    if (bytes.size() < header + length) break;
    std::string payload(bytes.substr(header, length));
    for (std::size_t i = 0; i < payload.size(); ++i) {
      payload[i] =
          static_cast<char>(static_cast<std::uint8_t>(payload[i]) ^ at(header - 4 + i % 4));
    }
    consumed_ += header + length;
    if (IsControl(opcode)) return Message{opcode, std::move(payload)};
    if ((opcode == Opcode::kContinuation) != fragmented_.has_value()) {
      return Fail(CloseCode::kProtocolError);
    }
    if (opcode != Opcode::kContinuation && fin) return Message{opcode, std::move(payload)};
    if (opcode != Opcode::kContinuation) fragmented_ = opcode;
    fragments_.append(payload);
    if (!fin) continue;
    Message whole{*fragmented_, std::move(fragments_)};
    fragments_.clear();
    fragmented_.reset();
    return whole;
  }
  if (consumed_ == buffer_.size()) {
    // An idle viewer keeps no bytes.
    buffer_ = {};
    consumed_ = 0;
  }
  return std::nullopt;
}

}  // namespace faultlab::server::websocket
