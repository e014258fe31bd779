#pragma once

#include <Eigen/Core>

#include "core/calibration/stretch_fit.h"

namespace faultlab::core {

/// What is known of a rig before anything is measured: its data sheet. Of the `n` coordinates of
/// the rig, then of the zeros of its channels, in units of their own.
/// @param scale  of the tolerances of parts
GaussianPrior DataSheetPrior(const ParameterOffsets& tolerance, double scale, int n, int zeros);

/// The fit under the most likely tolerance, and the covariance that the other tolerances add.
struct ToleranceChoice {
  MapFit fit;
  Eigen::MatrixXd tolerance_covariance;
  double tolerance_scale = 1.0;  ///< root mean square over the scales, by their probability
};

/// If a rig agrees with its data sheet in every quantity that can be estimated, the others are
/// assumed to agree too: the tolerances are scaled by the factor that makes the stretch most
/// likely.
/// @param widest  the fit under the tolerances as they are
ToleranceChoice ChooseTolerance(const HealthyStretch& stretch,
                                const ParameterOffsets& tolerance,
                                const RigParameters& base,
                                const NoiseLevel& noise,
                                const MapFit& widest);

}  // namespace faultlab::core
