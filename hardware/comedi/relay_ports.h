#pragma once

#include <cstdint>
#include <vector>

#include "hardware/comedi/comedi_board.h"
#include "hardware/comedi/comedi_daq.h"

namespace faultlab::hardware {

/// The relay lines on the digital subdevices of a board, up to 32 lines at a time. Line Do<i> is
/// the (relay_base + i)-th line of comedi.digital's subdevices, counted through them in their
/// order.
class RelayPorts {
 public:
  /// Only the description's relay lines are touched. Those that are no outputs yet become outputs
  /// at `nominal_levels`; lines that are outputs keep direction and level: another process may have
  /// left relays switched, and who opens the board moves them in their order (RelayBoard).
  /// Throws IoError when the subdevices have too few lines, with what there is.
  RelayPorts(const ComediBoard& board, const ComediChannels& channels);

  void Write(std::uint32_t levels) const;
  /// Bit i: level of Do<i>, 0 for lines that switch no relay.
  std::uint32_t Read() const;

 private:
  struct Line {
    unsigned bit;      ///< of the port
    std::uint32_t of;  ///< 1 << i of Do<i>
  };
  struct Port {
    int subdevice;
    unsigned base;       ///< channel of bit 0: 0, 32, ..
    bool has_direction;  ///< false: outputs only
    std::vector<Line> lines;
  };

  /// Finds the subdevice and channel of Do<line>.
  void Place(int line, const ComediChannels& channels);
  void MakeOutputs(const Port& port, std::uint32_t nominal_levels) const;
  bool IsOutput(const Port& port, const Line& line) const;
  /// @returns the levels of the port's 32 lines after writing those of `mask`
  std::uint32_t Bits(const Port& port, std::uint32_t mask, std::uint32_t bits) const;

  const ComediBoard& board_;
  std::vector<Port> ports_;
};

}  // namespace faultlab::hardware
