#pragma once

#include <optional>
#include <span>

#include "core/calibration/stretch_fit.h"
#include "core/types/calibration.h"

namespace faultlab::core {

/// What a healthy stretch says of its own calibration: no motor is quite the model.
struct SelfCheck {
  /// For the stated rate of false alarms. As given where the model is the motor; raised where not.
  DetectionThresholds thresholds;
  double raised = 1.0;    ///< the largest factor by which a level has been raised
  ModelError error;       ///< the calibration's, with what follows the steps of the input
  double judged_s = 0.0;  ///< how long was judged by what had been learnt from the rest
};

/// Learns from half of the stretch and judges the other half, both ways, by the shipping detector.
/// Levels follow the largest statistics of each second: a Gumbel distribution by moments,
/// extrapolated to the rate, never below what noise alone needs. Innovations that are more than
/// noise for some samples after each step of the input count less from then on. Nothing is raised
/// unless some statistic comes near its level, which white noise does in one stretch of ten seconds
/// out of some hundred.
/// @param calibration  complete; its thresholds are those of noise alone
/// @param stretch      what it was learnt from
/// @param as_read      the same samples with the readings that were left out of `stretch`
/// @param base, point  of the fit: the rig is RigAt(stretch, base, point)
/// @param prior        of the coordinates of the rig, without the zeros of its channels
/// No answer: nullopt where the halves are too short, or one of them is not excited.
/// Cost: two fits of a half of the stretch, and some detectors over it; allocates.
/// Source: E. J. Gumbel, Statistics of Extremes (1958); folds: M. Stone, J. Royal Stat. Soc. B 36
/// (1974).
std::optional<SelfCheck> CheckBySelf(const Calibration& calibration,
                                     const HealthyStretch& stretch,
                                     std::span<const Observation> as_read,
                                     const RigParameters& base,
                                     const Eigen::VectorXd& point,
                                     const NoiseLevel& noise,
                                     const GaussianPrior& prior);

/// What a person is told of it.
CalibrationCheck CheckOf(const SelfCheck& check);

}  // namespace faultlab::core
