#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "hardware/daq/channel_scaling.h"
#include "hardware/daq/daq.h"

namespace faultlab::hardware {

/// Where the bench's wires go on a board that Linux's Comedi drives. -1 = not wired.
struct ComediChannels {
  std::string library = "libcomedi.so.0";
  std::string device = "/dev/comedi0";
  int analog_in = 0;  ///< subdevices
  int analog_out = 1;
  int digital = 2;
  int counter = -1;
  int drive = 0;  ///< channels
  int um = 0;
  int ua = 1;
  int ia = 2;
  int counter_channel = 0;
  int relay_base = 0;                ///< channel of Do0
  std::uint32_t relay_lines = 0;     ///< bit i: line Do<i> switches a relay; others are left alone
  int range = 0;                     ///< index of the +-10 V range, both ways
  std::string reference = "ground";  ///< ground | common | diff
};

/// Loads libcomedi and opens the board; drive and relays stay as they are until written. Comedi
/// counts pulses; it has no frequency of its own. Throws IoError with the library's own words.
std::unique_ptr<Daq> OpenComedi(const ComediChannels& channels);

}  // namespace faultlab::hardware
