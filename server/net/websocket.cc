#include "server/net/websocket.h"

#include <openssl/evp.h>
#include <openssl/sha.h>

#include <array>

namespace faultlab::server::websocket {
namespace {

constexpr std::string_view kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
constexpr std::string_view kBase64Alphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::size_t kControlBytesMax = 125;

bool IsControl(Opcode opcode) {
  return static_cast<std::uint8_t>(opcode) >= 8;
}

bool IsKnown(std::uint8_t opcode) {
  return opcode <= 2 || (opcode >= 8 && opcode <= 10);
}

}  // namespace

std::string AcceptKey(std::string_view key) {
  const std::string text = std::string(key).append(kGuid);
  std::array<unsigned char, SHA_DIGEST_LENGTH> digest{};
  SHA1(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  std::array<unsigned char, 4 * ((SHA_DIGEST_LENGTH + 2) / 3) + 1> base64{};  // and a final NUL
  const int size = EVP_EncodeBlock(base64.data(), digest.data(), SHA_DIGEST_LENGTH);
  return {base64.begin(), base64.begin() + size};
}

bool IsValidKey(std::string_view key) {
  if (key.size() != 24 || key[22] != '=' || key[23] != '=') return false;
  return key.substr(0, 22).find_first_not_of(kBase64Alphabet) == std::string_view::npos;
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
    // Checked before any byte of the payload is waited for: a stated length of 2^63 costs nothing.
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
    // An idle viewer uses no buffer memory.
    buffer_ = {};
    consumed_ = 0;
  }
  return std::nullopt;
}

}  // namespace faultlab::server::websocket
