#include "core/types/sample_intake.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

/// All gaps longer than every window have the same effect; the bound keeps conversions defined.
constexpr std::int64_t kGapMax = 1'000'000'000;

}  // namespace

SampleStep SampleIntake::Classify(const Sample& sample) {
  std::int64_t step = 1;
  if (started_) {
    if (sample.index <= index_) {
      return {SampleUse::kIgnore, 0};
    }
    step = sample.index - index_;
    const double elapsed_periods = (sample.t_s - t_s_) / period_s_;
    if (elapsed_periods < kStepTolerancePeriods) {
      return {SampleUse::kIgnore, 0};
    }
    if (elapsed_periods > static_cast<double>(step) + kStepTolerancePeriods) {
      // The lines were numbered anew, so the gap is visible in the time column only.
      step = std::llround(std::min(elapsed_periods, static_cast<double>(kGapMax)));
    }
  }
  started_ = true;
  index_ = sample.index;
  t_s_ = sample.t_s;
  const double reading = ReadingOf(sample, channel_);
  const bool clipped = IsPlausible(reading) && std::abs(reading) >= limit_;
  return {clipped ? SampleUse::kClipped : SampleUse::kUse,
          static_cast<std::int32_t>(std::min(step, kGapMax) - 1)};
}

}  // namespace faultlab::core
