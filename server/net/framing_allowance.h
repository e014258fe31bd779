#pragma once

#include <cstddef>

namespace faultlab::server {

/// How much of a message may be neither header nor body: sizes of chunks, their extensions,
/// trailers. The parser has no limit for them. A body in chunks of one byte is within it.
class FramingAllowance {
 public:
  /// After the parser was given what has arrived.
  /// @param used  bytes that it took
  /// @param body_bytes  of the body, as far as it has come
  /// @param unread  bytes that it left, waiting for the rest of a line or of the trailers
  /// @returns false when the message is to be refused
  bool Covers(std::size_t used, std::size_t body_bytes, std::size_t unread) {
    used_ += used;
    return unread <= kBytes && used_ - body_bytes <= kBytes + kPerBodyByte * body_bytes;
  }

 private:
  static constexpr std::size_t kBytes = 16 << 10;
  static constexpr std::size_t kPerBodyByte = 8;
  std::size_t used_ = 0;
};

}  // namespace faultlab::server
