#pragma once

#include <Eigen/Core>
#include <span>

#include "core/filter/map_fit.h"
#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// Everything that the hypotheses about one stretch share.
struct FitContext {
  RigParameters rig;  ///< calibrated, with the faults that are known already
  NoiseLevel noise;
  GaussianPrior calibration;             ///< of the eight coordinates around `rig`
  Eigen::MatrixXd tolerance_covariance;  ///< as Calibration::tolerance_covariance, 8 x 8 or empty
  double part_tolerance = 0.0;           ///< relative, one standard deviation of one resistor
  std::span<const Observation> stretch;
  double period_s = kSamplePeriodSeconds;

  PredictionModel ModelOf(const RigParameters& of) const {
    return MakePredictionModel(of, noise, period_s);
  }
};

/// @param value  SI unit of the component, > 0
RigParameters WithComponent(const RigParameters& rig, Component component, double value);

/// Adds what one more healthy stretch says to the prior of the coordinates:
///   information <- information + J'J,   mean <- the MAP point of the stretch
/// The prior is left as it is when the stretch does not fit the rig (chi2/n above 1.15 + 4
/// sqrt(2/n), a point further than 31 from the mean in squared standard deviations, or no
/// convergence).
void UpdatePosterior(std::span<const Observation> stretch, FitContext& context);

}  // namespace faultlab::core
