#pragma once

#include <cmath>
#include <cstdint>

#include "core/types/sample.h"

namespace faultlab::core {

/// A step of run time within half a period of its nominal value is jitter; beyond it samples are
/// missing or repeated.
inline constexpr double kStepTolerancePeriods = 0.5;
/// End of a +-10 V converter.
inline constexpr double kConverterRail_v = 10.0;
/// A 16-bit converter of +-10 V has steps of 0.3 mV: within three of them of its end it is clipped.
inline constexpr double kRailMargin_v = 1e-3;

/// A reading beyond this is no voltage of any converter: treated as non-finite, so that squares of
/// garbage never enter a sum.
inline constexpr double kPlausibleMax_v = 1e6;

inline bool IsPlausible(double reading_v) {
  return std::abs(reading_v) < kPlausibleMax_v;  // false for NaN
}

enum class SampleUse {
  kIgnore,   ///< a repetition, or later than its successor: as if it had not come
  kUse,      ///< the next sample of the record; its values may still be non-finite
  kClipped,  ///< there, but um stands at the rail: a bound, not a value
};

struct SampleStep {
  SampleUse use = SampleUse::kUse;
  std::int32_t missing = 0;  ///< samples lost before this one
};

/// Says of each sample where it stands in its record, by index and by time. Estimators and
/// diagnosis share this one rule:
///   repeated or late  index not above the last one, or less than half a period after it
///   missing           what index and time skip, whichever is more
///   clipped           |um| >= um_rail_v - kRailMargin_v
class SampleIntake {
 public:
  explicit SampleIntake(double period_s, double um_rail_v = kConverterRail_v)
      : period_s_(period_s), um_limit_v_(um_rail_v - kRailMargin_v) {}

  SampleStep Classify(const Sample& sample);

 private:
  double period_s_;
  double um_limit_v_;
  bool started_ = false;
  std::int64_t index_ = 0;
  double t_s_ = 0.0;
};

/// Hands a sample to an estimator with Push(u, y), PushUnusable() and Skip(missing).
template <typename Estimator>
void Feed(const SampleStep& step, const Sample& sample, Estimator& estimator) {
  if (step.missing > 0) {
    estimator.Skip(step.missing);
  }
  if (step.use == SampleUse::kUse) {
    estimator.Push(sample.uc_v, sample.um_v);
  } else if (step.use == SampleUse::kClipped) {
    estimator.PushUnusable();
  }
}

}  // namespace faultlab::core
