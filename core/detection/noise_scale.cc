#include "core/detection/noise_scale.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

// A calibration has at least this many readings (stretch_checks.cc); a stored one may have any
// number.
constexpr double kReadingsMin = 100.0;
// Limit of v, in standard errors of a variance of nu_0 readings.
constexpr double kReach = 5.0;
// An innovation beyond four standard deviations (1 of 16 000) is not counted as noise.
constexpr double kSquareMax = 16.0;
constexpr double kForget = 1.0 - 1.0 / NoiseScale::kMemory;
// The rate of crossings falls by exp(-t/2) in the level t. When the scale of t has an error of
// variance 2/nu, the level t (1 + t / (2 nu)) restores the rate; t is about 28. The correction is
// doubled because the calibration's noise and parameters were fitted to the same readings.
constexpr double kInflationReadings = 28.0;

}  // namespace

NoiseScale::NoiseScale(int readings)
    : readings_(std::max(kReadingsMin, static_cast<double>(readings))) {
  const double standard_error = std::sqrt(2.0 / readings_);
  lowest_ = 1.0 / (1.0 + kReach * standard_error);
  highest_ = 1.0 + kReach * standard_error;
  threshold_inflation_ = 1.0 + kInflationReadings / readings_;
  weight_.fill(1.0);
}

void NoiseScale::Push(std::size_t channel, double z) {
  const double square = z * z;
  if (square > kSquareMax) return;
  count_[channel] = kForget * count_[channel] + 1.0;
  sum_[channel] = kForget * sum_[channel] + square;
  const double readings = readings_ + count_[channel];
  const double v = (readings_ + sum_[channel]) / readings;
  weight_[channel] = 1.0 / std::sqrt(std::clamp(v, lowest_, highest_));
  threshold_inflation_ = 1.0 + kInflationReadings / readings;
}

}  // namespace faultlab::core
