#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/calibration/stretch_fit.h"
#include "core/types/calibration.h"

namespace faultlab::core {

/// A stretch that tells that some channels do not read 0 at zero.
struct WithZeros {
  HealthyStretch stretch;
  Explained explained;
};

/// Zeros are learnt where they explain the stretch much better: on a rig whose channels are right
/// they would only cost certainty.
/// @param explained  the stretch without them
std::optional<WithZeros> LearnZeros(const HealthyStretch& without,
                                    const RigParameters& data_sheet,
                                    const ParameterOffsets& tolerance,
                                    std::optional<double> expected_delta_s,
                                    const Explained& explained);

/// Adds what the channels that were learnt from read at zero.
/// @param covariance  of the coordinates of the rig and those of stretch.zeros
void AddZeros(const HealthyStretch& stretch,
              const RigParameters& rig,
              const Eigen::MatrixXd& covariance,
              std::vector<CalibratedQuantity>& quantities);

}  // namespace faultlab::core
