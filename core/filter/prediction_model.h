#pragma once

#include <Eigen/Core>

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
/// s = sign of w, linear inside kCreepSpeed.
struct PredictionModel {
  Eigen::Matrix4d phi;
  Eigen::Vector4d g_prev;
  Eigen::Vector4d g;
  Eigen::Vector4d g_torque;
  Eigen::Matrix<double, kOutputCount, 4> c;
  Eigen::Vector3d d;
  double mc_nm = 0.0;
  double torque_step_variance = 0.0;  ///< of e
  double torque_variance = 0.0;       ///< stationary, of d
  std::array<double, kOutputCount> reading_variance{};
};

/// Slower than this the motor is not taken to turn one way for a whole period: at 10 ms Mc alone
/// changes w by about 2 rad/s.
inline constexpr double kCreepSpeed = 5.0;

/// Standard deviations of a state before its first reading: no drive reaches further.
inline constexpr double kPoleSdV = 10.0;
inline constexpr double kCurrentSdA = 2.0;
inline constexpr double kSpeedSdRadS = 500.0;

/// Contract: positive parameters, 0 < delta < period. Cost about 0.4 us.
PredictionModel MakePredictionModel(const RigParameters& rig,
                                    const NoiseLevel& noise,
                                    double period_s);

}  // namespace faultlab::core
