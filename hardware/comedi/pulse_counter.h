#pragma once

#include <cstdint>
#include <optional>

#include "hardware/comedi/comedi_board.h"
#include "hardware/comedi/comedi_daq.h"

namespace faultlab::hardware {

/// A counter of the board as one that counts from 0 and wraps at 2^32, whatever its own width.
class PulseCounter {
 public:
  /// Resets and arms the counter where its driver knows how; others run by themselves.
  PulseCounter(const ComediBoard& board, const ComediChannels& channels);

  /// Pulses since the first read; of a counter with direction forwards less backwards.
  std::uint32_t Read();

 private:
  const ComediBoard& board_;
  const unsigned subdevice_;
  const unsigned channel_;
  const CountDirection direction_;
  std::uint64_t modulus_ = 0;
  std::optional<std::uint64_t> before_;
  std::uint32_t pulses_ = 0;
};

}  // namespace faultlab::hardware
