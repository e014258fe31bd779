#pragma once

#include <array>
#include <cstddef>

#include "core/filter/observation.h"

namespace faultlab::core {

/// Ratio of a rig's noise to the noise in its calibration, and how well that ratio is known.
///   v_c = (nu_0 + sum of z^2) / (nu_0 + n),   z whitened by the calibration's noise
/// The calibration counts as nu_0 readings of variance 1; the sums forget over kMemory samples.
/// Some hundred readings leave an error of several percent in a variance. At an alarm level of five
/// standard deviations this makes tens of false alarms on an unlucky rig; the healthy record that
/// follows reduces the error. A fault is not learnt as noise: v stays within the sampling error of
/// nu_0 readings, and outliers are not counted. A plain value.
class NoiseScale {
 public:
  /// @param readings  nu_0, number of samples in the calibration
  explicit NoiseScale(int readings);

  /// Adds one whitened innovation of a channel, in the units of the calibration.
  void Push(std::size_t channel, double z);

  /// 1 / sqrt(v), by which whitened innovations are multiplied.
  double Weight(std::size_t channel) const { return weight_[channel]; }
  /// Alarm levels assume a known variance. If the variance was estimated from nu readings, levels
  /// higher by this factor give the same rate (Fisher's F against chi-square, to first order in
  /// 1/nu).
  double threshold_inflation() const { return threshold_inflation_; }

  static constexpr double kMemory = 20'000.0;

 private:
  double readings_;
  double lowest_;
  double highest_;
  double threshold_inflation_ = 1.0;
  std::array<double, kOutputCount> count_{};
  std::array<double, kOutputCount> sum_{};
  std::array<double, kOutputCount> weight_{};
};

}  // namespace faultlab::core
