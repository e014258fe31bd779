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
  GaussianPrior calibration;  ///< of the eight coordinates around `rig`
  Eigen::MatrixXd doubt;      ///< Calibration::covariance_doubt, 8 x 8
  double part_tolerance = 0.0;
  std::span<const Observation> stretch;
  double period_s = kSamplePeriodSeconds;

  PredictionModel ModelOf(const RigParameters& of) const {
    return MakePredictionModel(of, noise, period_s);
  }
};

RigParameters WithComponent(const RigParameters& rig, Component component, double value);

/// `rig` at the eight coordinates `q`.
RigParameters MovedBy(const FitContext& context,
                      const RigParameters& rig,
                      const Eigen::VectorXd& q);

/// Adds to what is known of the coordinates what one more healthy stretch tells; nothing when the
/// stretch does not fit the rig.
void LearnMore(std::span<const Observation> stretch, FitContext& context);

}  // namespace faultlab::core
