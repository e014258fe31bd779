#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace faultlab::hardware {

/// A line to a device. Never waits. Throws IoError when the line is gone.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  /// All or IoError: a device that does not take its commands is gone.
  virtual void Write(std::span<const std::uint8_t> bytes) = 0;
  /// @returns how many bytes were there.
  virtual std::size_t Read(std::span<std::uint8_t> bytes) = 0;
  /// Forgets what is on its way, in both directions, as far as this side holds it.
  virtual void Flush() = 0;
};

/// Raw, 8N1, any rate (TCSETS2), no flow control; does not drop DTR at the end, which resets some
/// boards. Throws IoError.
std::unique_ptr<ByteStream> OpenSerialLine(const std::string& path, int baud);
/// TCP_NODELAY; waits at most `patience_ms` for the connection. Throws IoError.
std::unique_ptr<ByteStream> OpenTcpLine(const std::string& host,
                                        const std::string& port,
                                        int patience_ms);

}  // namespace faultlab::hardware
