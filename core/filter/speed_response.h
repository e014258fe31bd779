#pragma once

#include <Eigen/Core>
#include <functional>

#include "core/filter/rig_parameters.h"
#include "core/types/calibration.h"
#include "core/types/speed_response.h"

namespace faultlab::core {

/// The response of the rig at `point`, with the errors that `covariance` (of the point's
/// coordinates) makes of them, to first order. La is neglected, as in core/plant/coefficients.h.
SpeedResponse SpeedResponseOf(const std::function<RigParameters(const Eigen::VectorXd&)>& rig_at,
                              const Eigen::VectorXd& point,
                              const Eigen::MatrixXd& covariance);

/// Of the rig that was calibrated.
SpeedResponse SpeedResponseOf(const Calibration& calibration);

}  // namespace faultlab::core
