#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server::websocket {

/// RFC 6455 close codes that this server sends.
enum class CloseCode : std::uint16_t {
  kNormal = 1000,
  kGoingAway = 1001,
  kProtocolError = 1002,
  kUnsupported = 1003,
  kInvalidText = 1007,
  kPolicy = 1008,
  kTooBig = 1009,
  kInternal = 1011,
  kTryAgainLater = 1013,
};

enum class Opcode : std::uint8_t {
  kContinuation = 0,
  kText = 1,
  kBinary = 2,
  kClose = 8,
  kPing = 9,
  kPong = 10,
};

/// Sec-WebSocket-Accept for a Sec-WebSocket-Key: base64(SHA-1(key + GUID)).
std::string AcceptKey(std::string_view key);
/// True for a Sec-WebSocket-Key: 16 bytes in base64.
bool IsValidKey(std::string_view key);

/// A complete unmasked server frame, FIN set.
std::string EncodeFrame(Opcode opcode, std::string_view payload);
std::string EncodeClose(CloseCode code, std::string_view reason);

/// Splits a client's byte stream into messages. Client frames must be masked; fragments are joined;
/// control frames may come between fragments. Holds at most `message_bytes_max` bytes.
class FrameReader {
 public:
  explicit FrameReader(std::size_t message_bytes_max) : message_bytes_max_(message_bytes_max) {}

  struct Message {
    Opcode opcode = Opcode::kText;  ///< kText, kBinary, kClose, kPing or kPong
    std::string payload;
  };
  /// Appends all of `bytes`; then call Next() until it returns nothing.
  void Append(std::string_view bytes);
  /// The next whole message; nullopt when more bytes are needed or after a protocol error.
  std::optional<Message> Next();
  /// Set after the peer violated the protocol; nothing more is read.
  std::optional<CloseCode> error() const { return error_; }

 private:
  std::optional<Message> Fail(CloseCode code);

  std::size_t message_bytes_max_;
  std::string buffer_;
  std::size_t consumed_ = 0;
  std::string fragments_;
  std::optional<Opcode> fragmented_;
  std::optional<CloseCode> error_;
};

}  // namespace faultlab::server::websocket
