#pragma once

#include <cstddef>
#include <span>

#include "core/filter/observation.h"
#include "core/filter/prediction_model.h"

namespace faultlab::core {

/// A single reading that is farther from its prediction than this many robust standard deviations
/// is an impulse: a bad contact, a relay that switches beside the wire. Of a million normal
/// readings 0.6 are as far.
inline constexpr double kImpulseGate = 5.0;

/// Which readings are taken out. Where that would be more than `share_max` of a channel (and more
/// than one), the model is wrong: then nothing is taken out, or, with `or_the_farthest`, the
/// farthest 2 % alone.
struct ImpulseRule {
  double gate = kImpulseGate;  ///< robust standard deviations
  double share_max = 0.05;
  bool or_the_farthest = false;
};

/// Takes the impulses out of `stretch`: clears their bits in `mask`. The scale is that of the
/// innovations themselves, by their median, so that impulses do not hide behind the noise that they
/// have made.
/// @returns how many readings were taken out
std::size_t LeaveOutImpulses(const PredictionModel& model,
                             std::span<Observation> stretch,
                             const ImpulseRule& rule = {});

}  // namespace faultlab::core
