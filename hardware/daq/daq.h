#pragma once

#include <cstdint>
#include <optional>

#include "hardware/io_error.h"
#include "hardware/relay_lines.h"

namespace faultlab::hardware {

/// Volts at the input terminals, read together.
struct AnalogReading {
  double um_v = 0.0;
  double ua_v = 0.0;
  double ia_v = 0.0;
  /// Seconds from the edge of the last WriteDrive to the conversion of um (of ia where um is not
  /// wired), where the driver knows it: by the board's clock, or as it reads one channel after the
  /// other. Else the middle of the call is taken for it.
  std::optional<double> middle_after_s = std::nullopt;
};

/// The converter, relay and counter lines of one bench: as thin as the drivers allow, terminal
/// volts and line levels, no meaning. Calls never overlap. A call that fails throws IoError.
class Daq : public RelayLines {
 public:
  /// Volt at the output terminal from now on. @returns what the converter makes of it.
  virtual double WriteDrive(double terminal_v) = 0;
  virtual AnalogReading ReadAnalog() = 0;

  /// Frequency of the encoder's pulses, hertz, 0 at standstill; negative backwards if the counter
  /// knows the sense.
  virtual double ReadPulseFrequencyHz() = 0;
  /// Pulses counted since the counter was set up; wraps at 2^32.
  virtual std::uint32_t ReadPulseCount() = 0;

  /// Sets up what must be set up before each run. Must leave drive and relays as they are.
  virtual void Prepare() = 0;
  /// Tells the board's own watchdog that the loop lives; nothing on boards without one.
  virtual void FeedWatchdog() = 0;
  /// True when the board itself goes to a safe state if its program dies.
  virtual bool has_watchdog() const = 0;
};

}  // namespace faultlab::hardware
