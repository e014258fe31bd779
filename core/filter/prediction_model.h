#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// The turning plant between two samples, exactly, with the slow part of its friction as a state:
///   x = (z, i, w, d): the amplifier's lag (V), current (A), speed (rad/s), slow friction torque in
///                     addition to Mc (Nm)
///   z' = (u - z)/lag,  Uout = k (a u + (1-a) z),  a = lead/lag
///   La i' = Uout - (Ra+Rs) i - Ke w
///   J w' = KT i - B w - s Mc - d,  d' = -d/tau + noise
/// where friction can hold the motor at rest (creep_rad_s 0), d turns around with it:
///   J w' = KT i - B w - s (Mc + d)
///   y = (Uout - Rs i, i, w), read delta after the edge of u
/// From sample to sample (T - delta under the old input, delta under the new one):
///   x+ = phi x + g_prev u_prev + g u + g_torque s Mc + (0, 0, 0, e)
///   scales y - zeros = c x + d u
/// s = sign of w (MeanDirection); u is what the supply lets through. Exact for piecewise constant
/// inputs while s is constant.
/// Source: paper Eq. (1)-(3); sampling by the matrix exponential, K. J. Astrom, B. Wittenmark,
/// Computer-Controlled Systems, 3rd ed. (1997), sections 2.3 and 2.4; symbols: core/README.md.
struct PredictionModel {
  Eigen::Matrix4d phi;                       ///< units of a row's state per unit of a column's
  Eigen::Vector4d g_prev;                    ///< per V of the input before the edge
  Eigen::Vector4d g;                         ///< per V of the input after the edge
  Eigen::Vector4d g_torque;                  ///< per Nm
  Eigen::Matrix<double, kOutputCount, 4> c;  ///< rows um (V), ia (A), w (rad/s)
  Eigen::Vector3d d;                         ///< the same per V of the input
  /// Of sensors that are being learnt or suspected. RunInnovations alone asks for them.
  std::array<double, kOutputCount> zeros{};
  std::array<double, kOutputCount> scales{1.0, 1.0, 1.0};
  /// Speed at the edge of the input: edge_w x + edge_w_u u_prev, and edge_w_torque per Nm.
  Eigen::Vector4d edge_w = Eigen::Vector4d::Zero();
  double edge_w_u = 0.0;
  double edge_w_torque = 0.0;
  double edge_kept = 1.0;   ///< share of a speed that is left at the edge
  double later_kept = 1.0;  ///< share of the speed at the edge that is left at the end
  double mc_nm = 0.0;
  double torque_step_variance = 0.0;                    ///< of e, Nm^2
  double torque_variance = 0.0;                         ///< stationary, of d, Nm^2
  double passage_variance = 0.0;                        ///< of w, by a whole passage, (rad/s)^2
  std::array<double, kOutputCount> reading_variance{};  ///< V^2, A^2, (rad/s)^2
  double creep_rad_s = 5.0;  ///< OperatingRange's; above 0: s = w / creep_rad_s within +-1
  /// Inputs at which the output meets the end of its supply.
  double u_min = -std::numeric_limits<double>::infinity();
  double u_max = std::numeric_limits<double>::infinity();
  /// Standard deviations of z, i, w before their first reading.
  Eigen::Vector3d start_sd = Eigen::Vector3d(10.0, 2.0, 500.0);
  double density = 1.0;  ///< samples in the time of one at 100 Hz, at least 1

  /// What the supply lets through of an input (V).
  double Limited(double u) const { return std::clamp(u, u_min, u_max); }
  bool limited() const { return std::isfinite(u_min) || std::isfinite(u_max); }
  /// Friction holds the motor at rest where the drive is too weak.
  bool holds() const { return creep_rad_s <= 0.0; }
  /// Not linear: the supply ends, or friction holds the motor at rest.
  bool saturates() const { return holds() || limited(); }
};

/// How friction acted in one step.
struct FrictionStep {
  double direction = 1.0;         ///< share and sign with which d acted
  double passage_variance = 0.0;  ///< that a passage through rest adds to that of the speed
};

/// Step where friction holds the motor at rest.
Eigen::Vector4d StepHeld(const PredictionModel& m,
                         const Eigen::Vector4d& x,
                         double u_prev,
                         double u,
                         FrictionStep& friction);

/// One sample further: the state x+ (V, A, rad/s, Nm) that follows `x` under the inputs (V) before
/// and after the edge, without noise. The inputs are what the supply lets through: Limited of each
/// where the supply ends. The only scalar form of the step; LaneFilter has the same step for
/// several models side by side.
[[gnu::always_inline]] inline Eigen::Vector4d Step(const PredictionModel& m,
                                                   const Eigen::Vector4d& x,
                                                   double u_prev,
                                                   double u,
                                                   FrictionStep& friction) {
  if (m.holds()) return StepHeld(m, x, u_prev, u, friction);
  const Eigen::Vector4d free = m.phi * x + m.g_prev * u_prev + m.g * u;
  return free + m.g_torque * (std::clamp(x(2) / m.creep_rad_s, -1.0, 1.0) * m.mc_nm);
}
[[gnu::always_inline]] inline Eigen::Vector4d Step(const PredictionModel& m,
                                                   const Eigen::Vector4d& x,
                                                   double u_prev,
                                                   double u) {
  FrictionStep friction;
  return Step(m, x, u_prev, u, friction);
}

/// Where the model settles under constant input, turning all the time; 0 if it does not settle.
Eigen::Vector4d TurningState(const PredictionModel& m, double u);

/// The model of one rig.
/// Contract: positive parameters, 0 < delta_s < period_s (ContractError). Parameters so large that
/// the exponential overflows give a model that is not finite; its predictions are NaN, and
/// ProfileCost counts them as the largest cost. Cost about 0.4 us.
PredictionModel MakePredictionModel(const RigParameters& rig,
                                    const NoiseLevel& noise,
                                    double period_s);

}  // namespace faultlab::core
