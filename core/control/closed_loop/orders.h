#pragma once

#include "core/bench/bench.h"
#include "core/control/control_order.h"
#include "core/filter/rig_parameters.h"
#include "core/types/calibration.h"
#include "core/types/verdict.h"

// What a diagnosis tells a drive.
namespace faultlab::core {

/// A rig's control begins so long after it is learnt.
inline constexpr double kControlAfterLearningS = 0.5;

/// Contract: period_s > 0, a rig of positive parameters.
SpeedModel SpeedModelOf(const RigParameters& rig, double period_s);

/// Of a rig as its bench is described, of which nothing is learnt yet.
DriveModel DescribedDrive(const Bench& bench, double period_s);

/// A fault is believed when its value's standard error is below a fifth of it, or the verdict is
/// settled. Contract: period_s > 0, a calibration of the bench.
ControlOrder OrderOf(const Bench& bench,
                     const Calibration& calibration,
                     const Verdict& verdict,
                     double period_s);

}  // namespace faultlab::core
