#include "core/types/sample_intake.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

/// Any gap beyond every window counts the same; the bound keeps conversions defined.
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
      // Lines numbered anew: the gap shows in the time column alone.
      step = std::llround(std::min(elapsed_periods, static_cast<double>(kGapMax)));
    }
  }
  started_ = true;
  index_ = sample.index;
  t_s_ = sample.t_s;
  const bool clipped = IsPlausible(sample.um_v) && std::abs(sample.um_v) >= um_limit_v_;
  return {clipped ? SampleUse::kClipped : SampleUse::kUse,
          static_cast<std::int32_t>(std::min(step, kGapMax) - 1)};
}

}  // namespace faultlab::core
