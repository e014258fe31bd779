#pragma once

#include <string>
#include <vector>

#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// One number of a calibration, with what the data added to what was known before.
struct CalibratedQuantity {
  std::string name;  ///< "k", "R1", "Ra", "J", "B", "Ke", "Mc", "delta"
  std::string unit;
  double value = 0.0;
  double sigma = 0.0;        ///< standard error (posterior)
  double prior_value = 0.0;  ///< data sheet
  double prior_sigma = 0.0;  ///< tolerance of the data sheet
  /// True when the stretch tightened the tolerance at least two-fold; false: these channels and
  /// this excitation cannot see the quantity and it stays what the data sheet says.
  bool from_data = false;
};

/// One test that the fault-free stretch had to pass.
struct CalibrationCheck {
  std::string name;      ///< "length", "excitation", "stationarity", "noise", ..
  std::string sentence;  ///< for a person, with the numbers
  double value = 0.0;
  double limit = 0.0;
  bool passed = false;
};

/// Alarm levels of the detection bank, all for the same share of the false-alarm budget.
struct DetectionThresholds {
  double false_alarms_per_day = 1.0;  ///< of the whole bank, at the rate of the record
  double residual = 0.0;              ///< |r| / sigma, largest over the channels
  double cusum = 0.0;                 ///< CUSUM of the squared whitened residual
  double glr_short = 0.0;             ///< W = 25 samples
  double glr_long = 0.0;              ///< W = 100 samples
  double glr_slow = 0.0;              ///< exponential window, 500 samples
};

/// What a fault-free stretch says about one rig. A plain value: store it, print it, load it.
struct Calibration {
  int version = 1;      ///< of this structure's meaning
  std::string dated;    ///< set by the caller (core knows no clock), free text, e.g. ISO 8601
  double from_s = 0.0;  ///< the stretch, half-open, run time
  double to_s = 0.0;
  int samples = 0;  ///< usable samples in it
  double period_s = kSamplePeriodSeconds;
  bool used_ia = false;
  bool used_n = false;

  /// The rig's own parameters: data sheet moved as far as the data ask for. R9, R12 and C8 stay at
  /// the data sheet; what the amplifier's gain differs by is in gain_factor.
  PlantParameters nominal;
  double gain_factor = 1.0;  ///< k = gain_factor * Re2 / Re1
  double delta_s = 0.0;      ///< DAC edge of uc(k) to ADC sample um(k)
  double mc_nm = 0.0;        ///< Coulomb friction torque
  double mc_sigma_nm = 0.0;

  double um_noise_v = 0.0;  ///< standard deviation of one reading
  double ia_noise_a = 0.0;
  double n_noise_rpm = 0.0;
  double friction_noise_nm = 0.0;  ///< rms of the slow part of the friction torque
  double friction_tau_s = 0.5;     ///< its correlation time (Ornstein-Uhlenbeck)

  std::vector<CalibratedQuantity> quantities;
  /// Posterior covariance of the coordinates (k, R1, Ra, J, B, Ke: logarithms; Mc: 0.1 mNm; delta:
  /// ms), 8 x 8, row-major.
  std::vector<double> covariance;
  /// Extra covariance from averaging over tolerance scales, weighted by evidence (same shape;
  /// empty: none). `covariance` is that of the likeliest scale alone; estimates use it, stated
  /// errors use the sum of both.
  std::vector<double> tolerance_covariance;
  /// How far one resistor of the amplifier may be off its data sheet, one standard deviation, as
  /// far as the stretch tells: nothing shows which of them an offset of the gain belongs to.
  double part_tolerance = 0.05;
  std::vector<CalibrationCheck> checks;
  DetectionThresholds thresholds;
};

}  // namespace faultlab::core
