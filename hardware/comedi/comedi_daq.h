#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hardware/daq/channel_scaling.h"
#include "hardware/daq/daq.h"

namespace faultlab::hardware {

/// What a counter makes of the encoder's pulses.
enum class CountDirection {
  kUp,
  kDown,  ///< as an 8254
  kBoth,  ///< up forwards, down backwards: it decodes both channels of the encoder
};

/// Where the bench's wires go on a board that Linux's Comedi drives. -1 = not wired.
struct ComediChannels {
  std::string library = "libcomedi.so.0";
  std::string device = "/dev/comedi0";
  int analog_in = 0;  ///< subdevices
  int analog_out = 1;
  std::vector<int> digital = {2};  ///< their lines are counted through in this order
  int counter = -1;
  int drive = 0;  ///< channels
  int um = 0;
  int ua = 1;
  int ia = 2;
  int counter_channel = 0;
  CountDirection counts = CountDirection::kUp;
  int relay_base = 0;                          ///< number of Do0 among the digital lines
  std::uint32_t relay_lines = 0;               ///< bit i: line Do<i> switches a relay
  std::uint32_t nominal_levels = 0xffffffffu;  ///< of those lines, nominal parts connected
  double drive_zero_v = 0.0;                   ///< terminal volts of drive 0
  int range = 0;                               ///< index of the +-10 V range, both ways
  std::string reference = "ground";            ///< ground | common | diff
  bool may_scan = true;                        ///< false: single reads, whatever the board can do
  /// Terminal volts that the inputs must be able to show, so that the interlocks can act; 0: any.
  double reach_v = 0.0;
  double delta_s = 0.0;  ///< drive edge to the middle of a scan
};

/// Loads libcomedi, opens the board and puts out drive 0 before anything else. Relay lines that are
/// no outputs yet become outputs at nominal levels; outputs keep their levels. Comedi counts
/// pulses; it has no frequency of its own. After Prepare, a board that clocks its converters
/// (analog_scan.h) converts delta_s after each WriteDrive, and ReadAnalog gives that scan; other
/// boards convert in ReadAnalog. Throws IoError with the library's own words, or with
/// what the board has instead of what the configuration names.
std::unique_ptr<Daq> OpenComedi(const ComediChannels& channels);

}  // namespace faultlab::hardware
