#include "core/detection/detection_thresholds.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace faultlab::core {
namespace {

// level(rate) = at_day + per_decade * log10(alarms per 24 h at 100 Hz of this test alone).
// Printed by tests/bench/alarm_levels.cc, which counts how often each statistic crosses a level in
// a simulated week of a rig whose parameters and noise are known exactly. The tail is exponential.
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

DetectionThresholds MakeThresholds(double false_alarms_per_day, double rate_hz, unsigned mask) {
  const bool several = std::popcount(mask) > 1;
  const Level residual_squared = several ? Level{30.2, -4.4} : Level{27.8, -4.3};
  const Level cusum = several ? Level{13.9, -2.4} : Level{13.3, -2.3};
  const Level glr_short = several ? Level{30.7, -4.7} : Level{30.3, -4.7};
  const Level glr_long = several ? Level{29.2, -4.9} : Level{29.1, -5.1};
  const Level glr_slow = Level{25.9, -4.9};
  // The share of one test in the false alarms, at the reference rate.
  const double alarms =
      std::max(1e-6, false_alarms_per_day / kTests * kReferenceRateHz / std::max(1e-3, rate_hz));
  DetectionThresholds t;
  t.false_alarms_per_day = false_alarms_per_day;
  t.residual = std::sqrt(LevelAt(residual_squared, alarms));
  t.cusum = LevelAt(cusum, alarms);
  t.glr_short = LevelAt(glr_short, alarms);
  t.glr_long = LevelAt(glr_long, alarms);
  t.glr_slow = LevelAt(glr_slow, alarms);
  return t;
}

}  // namespace faultlab::core
