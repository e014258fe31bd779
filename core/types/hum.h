#pragma once

#include <cmath>
#include <numbers>

namespace faultlab::core {

/// What the mains adds to the readings of um and ia: a sinusoid of one frequency,
///   cos(2 pi f t) * cosine + sin(2 pi f t) * sine,   t: run time.
struct Hum {
  struct Phasor {
    double cosine = 0.0;
    double sine = 0.0;
    double amplitude() const { return std::hypot(cosine, sine); }
    /// Standard deviation of a reading that it is in.
    double rms() const { return amplitude() / std::numbers::sqrt2; }
  };
  double frequency_hz = 0.0;  ///< 0: none
  Phasor um;                  ///< V
  Phasor ia;                  ///< A

  bool any() const { return frequency_hz > 0.0; }
};

}  // namespace faultlab::core
