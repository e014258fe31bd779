#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/calibration/stretch_fit.h"
#include "core/filter/observation.h"
#include "core/types/calibration.h"
#include "core/types/sample.h"

namespace faultlab::core {

struct VisibleChange {
  std::string symbol;  ///< of the component; "k" for all parts of an amplifier's gain
  double share = 0.0;  ///< of its value; infinite: only when it more than doubles
};

/// The smallest lasting change that raises an alarm under an input like that of the stretch, of
/// each coordinate that a component of the bench changes.
///   change = sqrt(level / sum of s^2),  s: change of a whitened innovation for a change of 1 in
///   the coordinate's logarithm, summed over the detector's windows; the best of their best tenth
/// Empty where nothing can be told.
std::vector<VisibleChange> VisibleChanges(const HealthyStretch& stretch,
                                          const RigParameters& rig,
                                          const NoiseLevel& noise,
                                          const DetectionThresholds& thresholds,
                                          const ModelError& error);
/// "Ra from 1.2 %, J only when it more than doubles"
std::string TextOf(std::span<const VisibleChange> changes);

/// The same of a healthy record of the rig that was learnt, whatever its input.
std::vector<VisibleChange> VisibleUnder(const Bench& bench,
                                        const Calibration& calibration,
                                        std::span<const Sample> samples,
                                        Channels channels,
                                        double um_rail_v);

}  // namespace faultlab::core
