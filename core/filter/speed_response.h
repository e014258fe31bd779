#pragma once

#include <Eigen/Core>
#include <functional>

#include "core/filter/rig_parameters.h"
#include "core/types/calibration.h"
#include "core/types/speed_response.h"

namespace faultlab::core {

/// The same numbers of one rig, without errors; speeds in rad/s of the motor shaft. La is
/// neglected, as in core/plant/coefficients.h; the amplifier's lag counts to the time constant.
struct SpeedNumbers {
  double gain = 0.0;  ///< rad/s for one volt of uc
  double time_constant_s = 0.0;
  double friction = 0.0;  ///< rad/s that Coulomb friction takes
};
SpeedNumbers SpeedNumbersOf(const RigParameters& rig);

/// The response of the rig at `point`, with the errors that `covariance` (of the point's
/// coordinates) makes of them, to first order.
SpeedResponse SpeedResponseOf(const std::function<RigParameters(const Eigen::VectorXd&)>& rig_at,
                              const Eigen::VectorXd& point,
                              const Eigen::MatrixXd& covariance);

/// Of the rig that was calibrated.
SpeedResponse SpeedResponseOf(const Calibration& calibration);

}  // namespace faultlab::core
