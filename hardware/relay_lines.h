#pragma once

#include <cstdint>

namespace faultlab::hardware {

/// The digital lines that switch a bench's relays. A call that fails throws IoError.
class RelayLines {
 public:
  virtual ~RelayLines() = default;

  /// Levels of the relay lines: bit i is line Do<i>.
  virtual void WriteRelayLines(std::uint32_t levels) = 0;
  /// Read back from the port, not from memory.
  virtual std::uint32_t ReadRelayLines() = 0;
};

}  // namespace faultlab::hardware
