#pragma once

#include <cstdint>
#include <optional>

#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// Looks at the measured delta of each sample. Its mean over a second that lies farther than
/// kDeltaTolerance from the described one is said once in a run: 1 ms is some 9 mV of um on the
/// published bench, which looks like a fault.
class DeltaWatch {
 public:
  static constexpr double kDeltaTolerance = 0.2e-3;  ///< seconds

  /// @param described_s  delta of the description or of `[loop] delta_ms`
  DeltaWatch(double described_s, double period_s);

  /// @returns the event, with the measured mean as its value.
  std::optional<RigEvent> Push(const core::Sample& sample);

 private:
  double described_s_;
  std::int64_t samples_a_second_;
  std::int64_t samples_ = 0;
  double sum_s_ = 0.0;
  bool said_ = false;
};

}  // namespace faultlab::hardware
