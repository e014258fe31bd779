#pragma once

#include <cmath>

namespace faultlab::core {

/// One-state model of the speed of a rig, rad/s of the motor shaft, sampled once a period:
///   w(k+1) = kept w(k) + (1 - kept) (gain u(k) - friction)
/// Of a rig that turns forward. La is neglected; the amplifier's lag counts to the time constant.
struct SpeedModel {
  double kept = 0.0;      ///< exp(-T / time constant)
  double gain = 1.0;      ///< rad/s per volt of uc, > 0
  double friction = 0.0;  ///< rad/s that Coulomb friction takes

  double Next(double w_rad_s, double u_v) const {
    return kept * w_rad_s + (1.0 - kept) * (gain * u_v - friction);
  }
  /// The input that leads from one speed to the next.
  double InputFor(double w_rad_s, double next_rad_s) const {
    return ((next_rad_s - kept * w_rad_s) / (1.0 - kept) + friction) / gain;
  }
  /// Standard deviation of the speed under an input that is two ticks up and two down by 1 V.
  double RipplePerVolt() const { return gain * (1.0 - kept) / std::sqrt(1.0 + kept * kept); }
  /// Where it settles.
  double Settled(double u_v) const { return gain * u_v - friction; }
};

/// Two states: the motor, and before it the amplifier, v(k+1) = lag_kept v(k) + (1 - lag_kept)
/// u(k), which hands on direct u + (1 - direct) v.
struct LaggedModel {
  SpeedModel motor;       ///< without the lag
  double lag_kept = 0.0;  ///< exp(-T / lag)
  double direct = 1.0;    ///< share of the gain that acts at once

  /// Of what the motor gets in a period, so much is of the lag's state at its beginning.
  double LagShare() const {
    // A lag that keeps less has nothing to remember.
    constexpr double kNothing = 0.02;
    return lag_kept > kNothing ? (1.0 - direct) * (1.0 - lag_kept) / -std::log(lag_kept) : 0.0;
  }
  /// What the motor gets in the mean of a period.
  double Handed(double u_v, double lag_v) const { return u_v + LagShare() * (lag_v - u_v); }
  /// The input under which the motor gets this. Contract: direct > 0.
  double InputFor(double handed_v, double lag_v) const {
    return (handed_v - LagShare() * lag_v) / (1.0 - LagShare());
  }
  /// The state of the lag a period later.
  double LagNext(double lag_v, double u_v) const {
    return lag_kept * lag_v + (1.0 - lag_kept) * u_v;
  }
};

}  // namespace faultlab::core
