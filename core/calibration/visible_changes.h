#pragma once

#include <string>

#include "core/calibration/stretch_fit.h"
#include "core/types/calibration.h"

namespace faultlab::core {

/// The smallest lasting change that raises an alarm under an input like that of the stretch, of
/// each coordinate that a component of the bench changes: "Ra from 1.2 %, J from 0.9 %".
///   change = sqrt(level / sum of s^2),  s: change of a whitened innovation for a change of 1 in
///   the coordinate's logarithm, summed over the detector's windows; the best of their best tenth
/// Empty where nothing can be told.
std::string VisibleChanges(const HealthyStretch& stretch,
                           const RigParameters& rig,
                           const NoiseLevel& noise,
                           const DetectionThresholds& thresholds);

}  // namespace faultlab::core
