#pragma once

#include <cstddef>
#include <span>

#include "core/filter/observation.h"
#include "core/filter/prediction_model.h"

namespace faultlab::core {

/// A reading farther from its prediction than this many robust standard deviations, while its
/// neighbours are not, is an impulse: a contact, a switched relay beside the wire. Of a thousand
/// normal readings 0.0006 are as far.
inline constexpr double kImpulseGate = 5.0;

/// Which readings are taken out.
struct ImpulseRule {
  double gate = kImpulseGate;  ///< robust standard deviations
  double share_max = 0.05;     ///< of the readings of a channel; where it would be more, the model
  /// is wrong and nothing is taken out, or it is only near and the farthest fiftieth is.
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
