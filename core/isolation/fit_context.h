#pragma once

#include <Eigen/Core>
#include <span>

#include "core/filter/map_fit.h"
#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// `base` moved by the coordinates `q`, as WithOffsets; but where B grows, it is 1 + q times as
/// large. What a record tells of a small B is how much torque it takes, so that its error is one of
/// B and not of its logarithm: of a B that is known within a half, four times as much is far off.
RigParameters Moved(const RigParameters& base,
                    const Eigen::Ref<const Eigen::VectorXd>& q,
                    double period_s);

/// The data that all hypotheses about one stretch share.
struct FitContext {
  RigParameters rig;  ///< calibrated, with the faults that are already known
  NoiseLevel noise;
  GaussianPrior calibration;             ///< of the coordinates around `rig`
  Eigen::MatrixXd tolerance_covariance;  ///< as Calibration::tolerance_covariance, or empty
  Eigen::MatrixXd model_covariance;      ///< as Calibration::model_covariance, or empty
  double part_tolerance = 0.0;           ///< relative, one standard deviation of one resistor
  /// The share of the amplifier's gain that acts at once is a coordinate, the last: its logarithm.
  bool direct_is_free = false;
  std::span<const Observation> stretch;
  double period_s = 0.01;
  bool follow_noise = false;  ///< MapFitOptions::follow_noise

  Eigen::Index coordinates() const { return calibration.mean.size(); }
  /// Those of the calibration.
  Eigen::Index calibrated() const { return coordinates() - (direct_is_free ? 1 : 0); }
  /// `base`, or `rig`, moved by all coordinates.
  RigParameters RigAt(const RigParameters& base, const Eigen::Ref<const Eigen::VectorXd>& q) const;
  RigParameters RigAt(const Eigen::Ref<const Eigen::VectorXd>& q) const { return RigAt(rig, q); }
  MapFitOptions FitOptions() const {
    MapFitOptions options;
    options.follow_noise = follow_noise;
    return options;
  }
  /// Where fits follow the noise, the noise of friction is known as an acceleration: torque and J
  /// are known by a common factor only, of which the noise must not decide.
  PredictionModel ModelOf(const RigParameters& of) const {
    if (!follow_noise) return MakePredictionModel(of, noise, period_s);
    NoiseLevel level = noise;
    level.friction_nm *= of.j_factor;
    return MakePredictionModel(of, level, period_s);
  }
};

/// The rig with another value of one component. A part that alone is the gain takes the offset of
/// the gain with it, and a capacitor that of the lag.
/// @param value  SI unit of the component, > 0
RigParameters WithComponent(const RigParameters& rig, Component component, double value);

/// `context` with the share of the amplifier's gain that acts at once as one more coordinate: only
/// a large capacitor shows it, so that no calibration has, and its resistors are known to their
/// tolerance.
FitContext WithFreeDirect(const FitContext& context);

/// Adds the information of one more healthy stretch to the prior of the coordinates:
///   information <- information + J'J,   mean <- the MAP point of the stretch
/// The prior stays unchanged when the stretch does not fit the rig (chi2/n above 1.15 + 4
/// sqrt(2/n), a point further than 31 from the mean in squared standard deviations, or no
/// convergence).
void UpdatePosterior(std::span<const Observation> stretch, FitContext& context);

}  // namespace faultlab::core
