#pragma once

#include "core/isolation/fit_context.h"
#include "core/isolation/isolation_task.h"
#include "core/types/calibration.h"

namespace faultlab::core {

/// The covariance of a calibration as a prior around it: 8 coordinates, or 9 with La, or 10 with
/// the amplifier's lag.
GaussianPrior PriorOf(const Calibration& calibration);

/// The calibrated rig without a fault, its noise and its prior; `stretch` is empty.
FitContext NominalContext(const IsolationTask& task);

}  // namespace faultlab::core
