#include "core/diagnosis/detection_thresholds.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace faultlab::core {
namespace {

// level(rate) = at_day + per_decade * log10(alarms per 24 h at 100 Hz of this test alone).
// Upcrossings (100 samples apart) of each statistic counted over 42 simulated hours of a healthy
// bench, data made by the prediction model itself, PRBS of 10 ms; the tail is exponential.
struct Level {
  double at_day;
  double per_decade;
};
constexpr double kReferenceRateHz = 100.0;
constexpr double kTests = 5.0;

double LevelAt(const Level& level, double alarms) {
  return level.at_day + level.per_decade * std::log10(alarms);
}

}  // namespace

DetectionThresholds MakeThresholds(double false_alarms_per_day,
                                   double rate_hz,
                                   unsigned mask,
                                   int calibration_samples) {
  const bool several = std::popcount(mask) > 1;
  const Level residual_squared = several ? Level{29.6, -4.5} : Level{28.1, -4.5};
  const Level cusum = several ? Level{14.2, -1.9} : Level{13.7, -1.9};
  const Level glr_short = Level{29.8, -4.3};
  const Level glr_long = Level{26.8, -4.2};
  const Level glr_slow = Level{26.0, -4.2};
  // Share of one test, at the reference rate.
  const double alarms =
      std::max(1e-6, false_alarms_per_day / kTests * kReferenceRateHz / std::max(1e-3, rate_hz));
  // A variance that rests on n readings has a standard error of sqrt(2/n): allow 1.5 of it.
  const double readings = std::max(50, calibration_samples);
  const double widen = 1.0 + 1.5 * std::sqrt(2.0 / readings);
  DetectionThresholds t;
  t.false_alarms_per_day = false_alarms_per_day;
  t.residual = std::sqrt(LevelAt(residual_squared, alarms) * widen);
  t.cusum = LevelAt(cusum, alarms) * widen;
  t.glr_short = LevelAt(glr_short, alarms) * widen;
  t.glr_long = LevelAt(glr_long, alarms) * widen;
  t.glr_slow = LevelAt(glr_slow, alarms) * widen;
  return t;
}

}  // namespace faultlab::core
