#pragma once

#include <Eigen/Core>
#include <array>

#include "core/types/calibration.h"
#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// What the prediction of one rig's samples needs beside the noise.
struct RigParameters {
  PlantParameters plant;
  double gain_factor = 1.0;  ///< k = gain_factor * Re2 / Re1
  double delta_s = 0.0095;
  double mc_nm = 0.0;

  double gain() const { return gain_factor * plant.gain(); }
};

/// Standard deviations of readings, and the slow part of the friction torque.
struct NoiseLevel {
  double um_v = 0.015;
  double ia_a = 0.001;
  double w_rad_s = 0.2;  ///< motor shaft
  double friction_nm = 0.02e-3;
  double friction_tau_s = 0.5;
};

/// The coordinates in which a rig may differ from its data sheet. All but Mc and delta are
/// logarithms of a factor on the data-sheet value, so that a tolerance is a plain number.
enum class Coordinate { kGain, kR1, kRa, kJ, kB, kKe, kMc, kDelta };

inline constexpr int kCoordinateCount = 8;
using ParameterOffsets = std::array<double, kCoordinateCount>;

/// Scales of the two linear coordinates: Mc in 0.1 mNm, delta in ms.
inline constexpr double kMcUnitNm = 1e-4;
inline constexpr double kDeltaUnitS = 1e-3;

/// `base` moved by `q`: gain_factor, R1, Ra, J, B, Ke (= KT) times exp(q), Mc and delta plus q.
/// delta is kept inside (0, period).
RigParameters WithOffsets(const RigParameters& base, const ParameterOffsets& q, double period_s);
/// The same for a vector of kCoordinateCount entries.
/// Contract: no other size.
RigParameters WithOffsets(const RigParameters& base,
                          const Eigen::Ref<const Eigen::VectorXd>& q,
                          double period_s);

inline constexpr double kRadPerSecondOfRpm = 2.0 * 3.14159265358979323846 / 60.0 * kGearRatio;

RigParameters ParametersOf(const Calibration& calibration);
NoiseLevel NoiseOf(const Calibration& calibration);
/// What detection must allow for: a few seconds hold some nine independent values of the friction's
/// slow noise (its rms may be 40 % low) and some hundreds of a reading's (3 %).
NoiseLevel DetectionNoiseOf(const Calibration& calibration);

}  // namespace faultlab::core
