#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "core/filter/observation.h"
#include "core/filter/prediction_model.h"

namespace faultlab::core {

/// A single reading that is farther from its prediction than this many robust standard deviations
/// is an impulse: a bad contact, a relay that switches beside the wire. Of a million normal
/// readings 0.6 are as far.
inline constexpr double kImpulseGate = 5.0;

/// Whether readings that are far off come one after the other: CUSUM of samples with one and of
/// samples without. Such samples are one in a hundred on a healthy rig with impulses, and more than
/// every other one where the model is wrong; four in a row pass the level.
class RowOfOddSamples {
 public:
  static constexpr double kLevel = 17.0;
  static constexpr int kSamples = 4;
  void Push(bool odd) { statistic_ = std::max(0.0, statistic_ + (odd ? 4.6 : -1.5)); }
  void Restart() { statistic_ = 0.0; }
  bool passed() const { return statistic_ > kLevel; }
  double statistic() const { return statistic_; }

 private:
  double statistic_ = 0.0;
};

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
