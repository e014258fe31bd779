#pragma once

namespace faultlab::core {

/// A number and its standard error.
struct Measured {
  double value = 0.0;
  double sigma = 0.0;
};

/// How the speed of a motor answers its input, to first order: what voltage and speed alone tell
/// without a data sheet.
///   time_constant dn/dt + n = gain uc - friction
struct SpeedResponse {
  Measured gain;           ///< rpm behind the gear for one volt of uc
  Measured time_constant;  ///< s
  Measured friction;       ///< rpm behind the gear that Coulomb friction takes
};

}  // namespace faultlab::core
