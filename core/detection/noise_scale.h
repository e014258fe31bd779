#pragma once

#include <array>
#include <cstddef>

#include "core/filter/observation.h"

namespace faultlab::core {

/// How far the noise of a rig is from what its calibration read, and how well that is known.
///   v_c = (nu_0 + sum of z^2) / (nu_0 + n),   z whitened by the calibration's noise
/// the calibration counts as nu_0 readings of variance 1; sums forget over kMemory samples. Some
/// hundred readings leave a variance uncertain by several percent, which an alarm level at five
/// standard deviations turns into tens of false alarms on an unlucky rig: the healthy record that
/// follows settles it. A fault cannot be learnt away: v stays inside what sampling error alone
/// makes of nu_0 readings, and what is far off is not counted. A plain value.
class NoiseScale {
 public:
  /// @param readings  nu_0, samples that the calibration rests on.
  explicit NoiseScale(int readings);

  /// One whitened innovation of a channel, in the calibration's units.
  void Push(std::size_t channel, double z);

  /// 1 / sqrt(v): multiplies whitened innovations.
  double Weight(std::size_t channel) const { return weight_[channel]; }
  /// Alarm levels are for a known variance; with nu readings behind it the same rate needs levels
  /// higher by this factor (Fisher's F against chi-square, to first order in 1/nu).
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
