#pragma once

#include <cstddef>

namespace faultlab::server {

/// Limits the part of a message that is neither header nor body: sizes of chunks, their extensions,
/// trailers. The parser has no limit for them. A body in chunks of one byte is allowed.
class FramingAllowance {
 public:
  /// To be called after the parser was given the bytes that have arrived.
  /// @param used  bytes that it consumed
  /// @param body_bytes  length of the body so far
  /// @param unread  bytes that it left, waiting for the rest of a line or of the trailers
  /// @returns false when the message must be refused
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
