#pragma once

#include <cstdint>
#include <string>

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

/// Of relay lines in messages: "0x0000ffff".
std::string Hex(std::uint32_t lines);
/// What a read-back that differs says. Precondition: they differ.
std::string LineDifference(std::uint32_t written, std::uint32_t read);

}  // namespace faultlab::hardware
