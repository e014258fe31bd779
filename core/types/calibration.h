#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/types/hum.h"
#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// One quantity of a calibration, before and after the data were used.
struct CalibratedQuantity {
  std::string name;  ///< "k", "R1", "Ra", "J", "B", "Ke", "Mc", "delta"
  std::string unit;
  double value = 0.0;
  double sigma = 0.0;        ///< standard error (posterior)
  double prior_value = 0.0;  ///< data sheet
  double prior_sigma = 0.0;  ///< tolerance of the data sheet
  /// True when the stretch reduced the tolerance at least to half. False: these channels and this
  /// excitation do not determine the quantity, and it keeps the value of the data sheet.
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

/// Alarm levels of the detection bank, all for the same share of the rate of false alarms.
struct DetectionThresholds {
  double false_alarms_per_day = 1.0;  ///< of the whole bank, at the rate of the record
  double residual = 0.0;              ///< |r| / sigma, largest over the channels
  double cusum = 0.0;                 ///< CUSUM of the squared whitened residual
  double glr_short = 0.0;             ///< W = 25 samples
  double glr_long = 0.0;              ///< W = 100 samples
  double glr_slow = 0.0;              ///< exponential window, 500 samples
};

/// What the model leaves of a healthy motor beyond noise, as the stretch has shown it. Nothing of a
/// rig that is as the model: then all is 1 and 0.
struct ModelError {
  static constexpr int kAges = 7;
  /// The least change of the input that is a step (V); 0: none has been looked at.
  double step_v = 0.0;
  /// By how much the standard deviation of an innovation of um, ia and n is more, by the time since
  /// the last step, in samples, or in 10 ms above 100 Hz: 0, 1, 2-3, 4-7, 8-15, 16-31, more.
  std::array<std::array<double, kAges>, 3> growth{
      {{1, 1, 1, 1, 1, 1, 1}, {1, 1, 1, 1, 1, 1, 1}, {1, 1, 1, 1, 1, 1, 1}}};
  /// How far Ra, Ke and B wander from their values, of their logarithms, one sd: a rig that warms
  /// up or runs in.
  std::array<double, 3> walk{};
  /// By how much the levels of the GLRs of the three windows are more than those of noise, by
  /// direction (Detector).
  static constexpr int kDirections = 9;
  std::array<std::array<double, kDirections>, 3> raised{
      {{1, 1, 1, 1, 1, 1, 1, 1, 1}, {1, 1, 1, 1, 1, 1, 1, 1, 1}, {1, 1, 1, 1, 1, 1, 1, 1, 1}}};

  static constexpr double kWalkMax = 1.0;  ///< with more, no change would be a fault
  bool walks() const { return walk != std::array<double, 3>{}; }
  bool any() const { return *this != ModelError{}; }
  friend bool operator==(const ModelError&, const ModelError&) = default;
};

/// The knowledge about one rig from a fault-free stretch. A plain value: store it, print it, load
/// it.
struct Calibration {
  int version = 1;      ///< of this structure's meaning
  std::string dated;    ///< set by the caller (core knows no clock), free text, e.g. ISO 8601
  double from_s = 0.0;  ///< the stretch, half-open, run time
  double to_s = 0.0;
  int samples = 0;  ///< usable samples in it
  double period_s = 0.01;
  bool used_um = true;
  bool used_ia = false;
  bool used_n = false;

  /// Bit c: channel c of um, ia and n was used.
  unsigned mask() const { return (used_um ? 1U : 0U) | (used_ia ? 2U : 0U) | (used_n ? 4U : 0U); }
  bool Uses(EstimatedChannel channel) const {
    return ((mask() >> static_cast<unsigned>(channel)) & 1U) != 0U;
  }

  /// The rig's own parameters: the data sheet corrected by the data. R9, R12 and C8 keep the data
  /// sheet's values; the offset of the amplifier's gain is in gain_factor.
  PlantParameters nominal;
  double gain_factor = 1.0;  ///< k = gain_factor * nominal.gain()
  double lag_factor = 1.0;   ///< of nominal.response().lag_s
  double delta_s = 0.0;      ///< DAC edge of uc(k) to ADC sample um(k)
  double mc_nm = 0.0;        ///< Coulomb friction torque
  double mc_sigma_nm = 0.0;
  double mc_unit_nm = 1e-4;  ///< scale of Mc in `covariance`

  double um_noise_v = 0.0;  ///< standard deviation of one reading
  double ia_noise_a = 0.0;
  double n_noise_rpm = 0.0;
  /// What the channels read at zero; taken out of every reading before it is used.
  double um_zero_v = 0.0;
  double ia_zero_a = 0.0;
  double n_zero_rpm = 0.0;
  /// Of the stretch; taken out of the readings of the same run alone, for its phase is of that run.
  /// The noise above is without it.
  Hum hum;
  /// Share of the readings that stood alone, far from their prediction, and were left out. Above 0
  /// single readings raise no alarm.
  double impulse_share = 0.0;
  double friction_noise_nm = 0.0;  ///< rms of the slow part of the friction torque
  double friction_tau_s = 0.5;     ///< its correlation time (Ornstein-Uhlenbeck)

  std::vector<CalibratedQuantity> quantities;
  /// Posterior covariance of the coordinates (k, R1, Ra, J, B, Ke: logarithms; Mc: mc_unit_nm;
  /// delta: a tenth of the period; of some benches also La, and the amplifier's lag:
  /// logarithms), 8 x 8, 9 x 9 or 10 x 10, row-major.
  std::vector<double> covariance;
  /// Extra covariance from averaging over tolerance scales, weighted by evidence (same shape;
  /// empty: none). `covariance` is that of the likeliest scale alone; estimates use it, stated
  /// errors use the sum of both.
  std::vector<double> tolerance_covariance;
  /// What physics that the model lacks may have done to the coordinates (same shape; empty: nothing
  /// is known). Part of stated errors alone, and of every value that is measured with the rig.
  std::vector<double> model_covariance;
  /// Standard deviation of one resistor of the amplifier from its data sheet, as far as the stretch
  /// shows: nothing tells which of them causes an offset of the gain.
  double part_tolerance = 0.05;
  std::vector<CalibrationCheck> checks;
  DetectionThresholds thresholds;
  ModelError model_error;
};

}  // namespace faultlab::core
