#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/types/estimated_channel.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// A step of run time within half a period of its nominal value is jitter; beyond it samples are
/// missing or repeated.
inline constexpr double kStepTolerancePeriods = 0.5;
/// The end of the range of a +-10 V converter.
inline constexpr double kConverterRail_v = 10.0;
/// A 16-bit converter of +-10 V has steps of 0.3 mV; a reading within three steps of the end is
/// clipped.
inline constexpr double kRailMargin_v = 1e-3;

/// A larger reading is not a voltage of any converter. It is treated as non-finite, so that its
/// square never enters a sum.
inline constexpr double kPlausibleMax_v = 1e6;

inline bool IsPlausible(double reading_v) {
  return std::abs(reading_v) < kPlausibleMax_v;  // false for NaN
}

/// Readings of a channel that lie between the ends of its converter.
struct ReadingRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();

  bool Holds(double reading) const { return reading > min && reading < max; }
};

/// Which readings of a bench are values (Bench::readings).
struct ReadingRules {
  bool has_um = false;
  bool has_ia = false;
  bool has_n = false;
  bool of_row_before = false;  ///< readings follow the input of the row before
  ReadingRange ia;             ///< A; outside is no reading
  /// Motor shaft; a slower speed is no reading, unless the motor should turn much faster.
  double speed_floor_rad_s = 0.0;
  /// By the data sheet, of the motor shaft: rad/s for a volt of uc, what friction takes of them,
  /// and the time constant.
  double speed_per_v = 0.0;
  double speed_friction_rad_s = 0.0;
  double speed_time_constant_s = 0.0;
  double gear_ratio = 1.0;  ///< motor shaft : the shaft whose speed n is
};

enum class SampleUse {
  kIgnore,   ///< a repetition, or older than a sample already used; it is skipped
  kUse,      ///< the next sample of the record; its values may still be non-finite
  kClipped,  ///< present, but um is at the rail and is only a bound
};

struct SampleStep {
  SampleUse use = SampleUse::kUse;
  std::int32_t missing = 0;  ///< samples lost before this one
};

/// Classifies each sample by its index and time within the record. Estimators and diagnosis share
/// this rule:
///   repeated or late  index not above the last one, or less than half a period after it
///   missing           the samples skipped by index or by time, whichever is more
///   clipped           |y| >= rail - kRailMargin_v; y: um, or the requested channel
class SampleIntake {
 public:
  explicit SampleIntake(double period_s,
                        double rail = kConverterRail_v,
                        EstimatedChannel channel = EstimatedChannel::kUm)
      : period_s_(period_s), limit_(rail - kRailMargin_v), channel_(channel) {}

  SampleStep Classify(const Sample& sample);

 private:
  double period_s_;
  double limit_;  ///< of |y|, unit of the channel
  EstimatedChannel channel_;
  bool started_ = false;
  std::int64_t index_ = 0;
  double t_s_ = 0.0;
};

/// Hands a sample to an estimator with Push(u, y), PushUnusable() and Skip(missing).
template <typename Estimator>
void Feed(const SampleStep& step,
          const Sample& sample,
          Estimator& estimator,
          EstimatedChannel channel = EstimatedChannel::kUm) {
  if (step.missing > 0) {
    estimator.Skip(step.missing);
  }
  if (step.use == SampleUse::kUse) {
    estimator.Push(sample.uc_v, ReadingOf(sample, channel));
  } else if (step.use == SampleUse::kClipped) {
    estimator.PushUnusable();
  }
}

}  // namespace faultlab::core
