#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// The turning plant between two samples, exactly, with the slow part of its friction as a state:
///   x = (z, i, w, d): C8's pole (V), current (A), speed (rad/s), friction torque beside Mc (Nm)
///   z' = (u - z)/((Re2+R5) C8)      Uout = k (a u + (1-a) z),  a = R5/(Re2+R5)
///   La i' = Uout - (Ra+R1) i - Ke w   J w' = KT i - B w - s Mc - d   d' = -d/tau + noise
///   y = (Uout - R1 i, i, w), read delta after the edge of u
/// From sample to sample (T - delta under the old input, delta under the new one):
///   x+ = phi x + g_prev u_prev + g u + g_torque s Mc + (0, 0, 0, e),   y = c x + d u
/// s = sign of w, linear inside kCreepSpeed. Exact for piecewise constant inputs while s is
/// constant.
/// Source: paper Eq. (1)-(3); sampling by the matrix exponential, K. J. Astrom, B. Wittenmark,
/// Computer-Controlled Systems, 3rd ed. (1997), sections 2.3 and 2.4; symbols: core/README.md.
struct PredictionModel {
  Eigen::Matrix4d phi;                       ///< units of a row's state per unit of a column's
  Eigen::Vector4d g_prev;                    ///< per V of the input before the edge
  Eigen::Vector4d g;                         ///< per V of the input after the edge
  Eigen::Vector4d g_torque;                  ///< per Nm
  Eigen::Matrix<double, kOutputCount, 4> c;  ///< rows um (V), ia (A), w (rad/s)
  Eigen::Vector3d d;                         ///< the same per V of the input
  double mc_nm = 0.0;
  double torque_step_variance = 0.0;                    ///< of e, Nm^2
  double torque_variance = 0.0;                         ///< stationary, of d, Nm^2
  std::array<double, kOutputCount> reading_variance{};  ///< V^2, A^2, (rad/s)^2
};

/// rad/s. Slower than this the motor is not taken to turn one way for a whole period: at 10 ms Mc
/// alone changes w by about 2 rad/s.
inline constexpr double kCreepSpeed = 5.0;

/// One sample further: the state x+ (V, A, rad/s, Nm) that follows `x` under the inputs (V) before
/// and after the edge, noise left out. The only scalar form of the step; LaneFilter has the same
/// one for several models side by side.
[[gnu::always_inline]] inline Eigen::Vector4d Step(const PredictionModel& m,
                                                   const Eigen::Vector4d& x,
                                                   double u_prev,
                                                   double u) {
  const double sign = std::clamp(x(2) / kCreepSpeed, -1.0, 1.0);
  return m.phi * x + m.g_prev * u_prev + m.g * u + m.g_torque * (sign * m.mc_nm);
}

/// Standard deviations of a state before its first reading (V, A, rad/s): no drive reaches further.
inline constexpr double kPoleSdV = 10.0;
inline constexpr double kCurrentSdA = 2.0;
inline constexpr double kSpeedSdRadS = 500.0;

/// The model of one rig.
/// Contract: positive parameters, 0 < delta_s < period_s (ContractError). Parameters so large that
/// the exponential overflows give a model that is not finite; its predictions are NaN, and
/// ProfileCost counts them as the largest cost. Cost about 0.4 us.
PredictionModel MakePredictionModel(const RigParameters& rig,
                                    const NoiseLevel& noise,
                                    double period_s);

}  // namespace faultlab::core
