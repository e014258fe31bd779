#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "core/filter/observation.h"
#include "core/types/calibration.h"

namespace faultlab::core {

/// How many samples ago the input has stepped, as ModelError::growth counts them, whatever the
/// rate.
class StepAge {
 public:
  /// @param step_v  ModelError::step_v
  std::size_t Push(const Observation& o, double step_v) {
    samples_ = std::abs(o.u - o.u_prev) >= step_v ? 0U : std::min(samples_ + 1U, 1000U);
    return std::min<std::size_t>(std::bit_width(samples_), ModelError::kAges - 1);
  }

 private:
  unsigned samples_ = 1000;
};

}  // namespace faultlab::core
