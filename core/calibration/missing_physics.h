#pragma once

#include <Eigen/Core>

#include "core/calibration/stretch_fit.h"

namespace faultlab::core {

/// How far physics that the model lacks, and channels whose scale is off, may have moved the fitted
/// coordinates: their covariance [n x n], n without the zeros of the channels. No error that
/// follows from noise covers it, and no record shows it where the input has two levels only.
///   G = -(S'S + prior)^-1 S'c,   r = c + S G,   I = r'r + 1,   h = r'z / I
///   covariance = sum over the terms of min(1, 4 h^2 + 1 / I) G G'
/// c: what one typical term does to the whitened innovations z; S: their sensitivities to the
/// coordinates. Terms: drop, resistance and speed dependence of the brushes, an output that gives
/// way, air, friction that falls with the speed; BenchChannel::gain_sd of um, ia and n.
/// @param fit  of `stretch` around `base`
/// Cost: some twenty passes of the filter; allocates.
/// Source: consider covariance, S. F. Schmidt, Advances in Control Systems 3 (1966), 293.
Eigen::MatrixXd MissingPhysics(const HealthyStretch& stretch,
                               const RigParameters& base,
                               const MapFit& fit,
                               const NoiseLevel& noise);

}  // namespace faultlab::core
