#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// The turning plant as its converters sample it, exactly (no reduction, La and the amplifier's lag
/// included):
///   x = (v, i, w) at t_k, v as in Plant,   x(k+1) = phi x(k) + gamma_u u(k) + gamma_m Mc
///   outputs (um, ia, w) at t_k + delta:  y(k) = c x(k) + d_u u(k) + d_m Mc
/// Mc > 0 opposes w > 0. Valid while the motor turns forward, outside the output limits.
struct SampledModel {
  Eigen::Matrix3d phi;
  Eigen::Vector3d gamma_u;
  Eigen::Vector3d gamma_m;
  Eigen::Matrix3d c;    ///< rows um, ia, w
  Eigen::Vector3d d_u;  ///< rows um, ia, w
  Eigen::Vector3d d_m;

  /// State at rest under a constant input: (I - phi) x = gamma_u u + gamma_m Mc.
  Eigen::Vector3d SteadyState(double uc_v, double mc_nm) const;
};

/// Contract: positive parameters, 0 <= delta < period.
SampledModel MakeSampledModel(const PlantParameters& parameters, double period_s, double delta_s);

/// The share of Mc that acts in each period, -1 to 1: the mean sign of the speed of a motor that
/// starts at rest under u(0..n-1). Empty, for 1 throughout, where u has not both signs.
std::vector<double> FrictionDirections(const SampledModel& model,
                                       std::span<const double> uc_v,
                                       double mc_nm);

/// Output `row` of the model (0 um, 1 ia, 2 w) from x(0) = x0 under u(0..n-1) and Mc, times
/// `directions` [n] if there are any. y [n], same length as uc. Returns the state after the last
/// sample.
Eigen::Vector3d Simulate(const SampledModel& model,
                         int row,
                         std::span<const double> uc_v,
                         double mc_nm,
                         const Eigen::Vector3d& x0,
                         std::span<double> y,
                         std::span<const double> directions = {});

}  // namespace faultlab::core
