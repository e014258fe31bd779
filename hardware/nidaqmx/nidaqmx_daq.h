#pragma once

#include <memory>
#include <string>

#include "hardware/daq/channel_scaling.h"
#include "hardware/daq/daq.h"

namespace faultlab::hardware {

/// Where the bench's wires go on NI modules; the paper's are 9205 (analog in), 9263 (analog out),
/// 9402 (counter), 9403 (relays).
struct NiDaqmxChannels {
  std::string library = "libnidaqmx.so.1";
  std::string drive = "cRIO1Mod2/ao0";
  std::string um = "cRIO1Mod1/ai0";
  std::string ua = "cRIO1Mod1/ai1";  ///< empty = not wired
  std::string ia = "cRIO1Mod1/ai2";  ///< empty = not wired
  std::string terminal = "rse";      ///< rse | nrse | diff
  std::string relays = "cRIO1Mod4/port0";
  std::string counter = "cRIO1Mod3/ctr0";  ///< empty = not wired
  /// The counter decodes both channels of the encoder, four counts a pulse, backwards downwards.
  bool quadrature = false;
  /// Device with a watchdog of its own that puts the drive to 0 V; empty = the device has none.
  std::string watchdog;
  double watchdog_s = 0.2;  ///< without being fed, once every sample
};

/// Loads the driver and sets the tasks up; drive and relays stay as they are until written.
/// With `quadrature`, `speed` is kGatedCount. Throws IoError with the driver's own words.
std::unique_ptr<Daq> OpenNiDaqmx(const NiDaqmxChannels& channels, SpeedMethod speed);

}  // namespace faultlab::hardware
