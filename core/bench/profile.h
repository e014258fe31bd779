#pragma once

#include <cmath>
#include <string>

namespace faultlab::core {

/// Karnopp friction with a Stribeck term (paper Eq. (1)); the viscous part B w is in
/// PlantParameters.
///   standing, |KT i| <= Ms: stays;   turning: (Mc + (Ms-Mc) exp(-|w/wk|^shape) + n(t)) sgn(w)
/// n(t) is an Ornstein-Uhlenbeck process, dn = -n/tau dt + rms sqrt(2/tau) dW.
struct FrictionModel {
  double mc_nm = 0.0;                   ///< Coulomb friction Mc
  double ms_nm = 0.0;                   ///< static friction Ms >= Mc
  double stribeck_speed_rad_s = 5.0;    ///< wk
  int stribeck_shape = 2;               ///< the paper's delta: 1 Tustin, 2 Gauss; 0: no such term
  double standstill_speed_rad_s = 0.1;  ///< Dw: below it, and slowing down, the motor stands
  double noise_rms_nm = 0.0;
  double noise_tau_s = 0.5;

  /// What a slowly turning motor takes more than Mc, Nm.
  double StribeckTorque(double speed_rad_s) const {
    if (stribeck_shape == 0) return 0.0;
    const double ratio = std::abs(speed_rad_s) / stribeck_speed_rad_s;
    const double exponent = stribeck_shape == 1 ? ratio : ratio * ratio;
    return (ms_nm - mc_nm) * std::exp(-exponent);
  }
};

enum class Quadrants {
  kTwo,   ///< output voltage of one sign, current of both
  kFour,  ///< output voltage and current of both signs
};

struct AmplifierModel {
  Quadrants quadrants = Quadrants::kTwo;
  double output_max_v = 15.0;  ///< limit given by the supply; two quadrants: 0 .. max
  double gain_error = 0.0;     ///< relative, of this amplifier: within kAmplifierAccuracy
};

inline constexpr double kAmplifierAccuracy = 0.01;  ///< paper section 2.1.2: 1 % of the range

/// Standard deviations of white measurement noise, before the converters.
struct NoiseLevels {
  double um_v = 0.0;
  double ua_v = 0.0;
  double ia_a = 0.0;
  double n_rpm = 0.0;
};

/// How a bench's readings are digitised. A channel that does not exist reads nothing.
struct Converters {
  bool has_um = true;
  bool has_ua = true;
  bool has_ia = true;
  bool has_n = true;
  bool tachometer = false;  ///< n is a voltage, read at any speed; else it is of an encoder
  bool counts = false;      ///< n is of pulses counted over a period, else of the time between two
  double range_v = 10.0;    ///< converters of uc, um and ua read -range .. range, 16 bit
  double ia_v_per_a = 1.0;  ///< scales ia to its converter
  int pulses_per_revolution = 1000;  ///< of the encoder, on the motor shaft
};

/// The properties of a simulator of a bench, except its component values.
struct BenchProfile {
  std::string name;
  double delta_s = 0.0;  ///< DAC edge of uc(k) to ADC sample um(k)
  FrictionModel friction;
  AmplifierModel amplifier;
  NoiseLevels noise;
  Converters converters;
};

}  // namespace faultlab::core
