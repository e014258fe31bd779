#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "core/types/calibration.h"
#include "core/types/time_span.h"

namespace faultlab::core {

/// How long ago the input has stepped, as ModelError::growth counts it.
class StepAge {
 public:
  explicit StepAge(double period_s) : unit_(SpanOf(1, period_s)) {}

  /// @param change_v  of the input, in this sample
  /// @param step_v    ModelError::step_v
  std::size_t Push(double change_v, double step_v) {
    samples_ = std::abs(change_v) >= step_v ? 0 : std::min(samples_ + 1, kLong * unit_);
    return std::min<std::size_t>(std::bit_width(samples_ / unit_), ModelError::kAges - 1);
  }

 private:
  static constexpr std::size_t kLong = 1000;
  std::size_t unit_;  ///< samples
  std::size_t samples_ = kLong * unit_;
};

}  // namespace faultlab::core
