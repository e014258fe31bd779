#pragma once

#include <Eigen/Core>
#include <array>

#include "core/types/calibration.h"
#include "core/types/component.h"
#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// The parameters that predict the samples of one rig, except its noise.
struct RigParameters {
  PlantParameters plant;
  double gain_factor = 1.0;  ///< k = gain_factor * plant.gain()
  double delta_s = 0.0;
  double mc_nm = 0.0;
  double mc_unit_nm = 1e-4;  ///< scale of the coordinate kMc
  int gain_part = -1;        ///< the parameter that alone is the gain, as Component's; -1: several
  double j_factor = 1.0;     ///< what WithOffsets has made of J
  double lag_factor = 1.0;   ///< of the amplifier's lag_s
  double direct_factor = 1.0;  ///< of the share of its gain that acts at once
  /// What the channels read at zero, while it is being learnt; then it is taken out of the
  /// readings.
  std::array<double, 3> zeros{};
  /// Of readings: what one says too little of its quantity. 1 unless a sensor is suspected.
  std::array<double, 3> scales{1.0, 1.0, 1.0};

  double gain() const { return gain_factor * plant.gain(); }
};

/// Standard deviations of readings, and the slow part of the friction torque.
struct NoiseLevel {
  double um_v = 0.0;
  double ia_a = 0.0;
  double w_rad_s = 0.0;  ///< motor shaft
  double friction_nm = 0.0;
  double friction_tau_s = 0.5;
  double passage_rad_s = 0.0;  ///< of the speed, by a passage through rest: PassageNoise
};

/// What a whole passage of a motor through rest adds to the standard deviation of its speed
/// (rad/s): the speed is not linear in time meanwhile, and friction around rest is more than
/// Coulomb's. A share of what friction changes the speed by in a period; of the rig as described or
/// learned, so that a fit gains nothing by changing it.
double PassageNoise(double mc_nm, double j_kg_m2, double period_s);

/// The coordinates in which a rig may differ from its data sheet. All but Mc and delta are
/// logarithms of a factor on the data-sheet value, so that a tolerance is a plain number.
enum class Coordinate { kGain, kSeries, kRa, kJ, kB, kKe, kMc, kDelta, kLa, kLag };

/// Every bench has the first 8. La is one where its data sheet states a tolerance of it, else it is
/// held; the amplifier's lag is one where it can be seen. (The share of its gain that acts at once
/// is held: readings once a period show it no other than delta.)
inline constexpr int kCoordinateCount = 8;
inline constexpr int kCoordinateCountWithLa = 9;
inline constexpr int kCoordinateMax = 10;
constexpr bool IsCoordinateCount(Eigen::Index n) {
  return n == kCoordinateCount || n == kCoordinateCountWithLa || n == kCoordinateMax;
}
using ParameterOffsets = std::array<double, kCoordinateMax>;

/// Units of the two linear coordinates: Mc in RigParameters::mc_unit_nm, delta in this share of the
/// period.
inline constexpr double kDeltaUnitPeriods = 0.1;

/// `base` moved by `q`: gain_factor, Rs, Ra, J, B, Ke (= KT), La, lag_factor times
/// exp(q), Mc and delta plus q. delta is kept inside (0, period).
RigParameters WithOffsets(const RigParameters& base, const ParameterOffsets& q, double period_s);
/// The same for a vector. Contract: IsCoordinateCount(q.size()).
RigParameters WithOffsets(const RigParameters& base,
                          const Eigen::Ref<const Eigen::VectorXd>& q,
                          double period_s);

/// What moves in a healthy rig that warms up, and how far beside Ra. Source of the figures: copper
/// changes by 0.4 % per kelvin, and magnets and lubricants soften.
struct WarmingPart {
  Coordinate coordinate;
  MotorParameter parameter;
  double share;
};
inline constexpr std::array<WarmingPart, 3> kWarmingParts = {
    {{Coordinate::kRa, kRa, 1.0}, {Coordinate::kKe, kKe, 0.4}, {Coordinate::kB, kB, 3.3}}};
/// ModelError::walk as offsets of the coordinates.
ParameterOffsets WalkOf(const ModelError& error);
/// Calibration::covariance, and how far the rig walks.
Eigen::MatrixXd CovarianceOf(const Calibration& calibration);

/// The coordinate that a component changes by itself: that of its parameter of the motor, or kGain
/// for a part of the amplifier that has a say in the gain; -1: none.
int CoordinateOf(const ComponentInfo& part, const PlantParameters& plant);

/// RigParameters::gain_part.
int GainPartOf(const PlantParameters& plant);
RigParameters ParametersOf(const Calibration& calibration);
NoiseLevel NoiseOf(const Calibration& calibration);
/// For readings of which nobody takes the hum out, as those of another run: it is part of the
/// noise.
Calibration WithHumAsNoise(const Calibration& calibration);
/// The noise that detection must allow for. A few seconds hold only some nine independent values of
/// the slow friction noise (its rms may be 40 % too low), but some hundreds of a reading's noise (3
/// %).
NoiseLevel DetectionNoiseOf(const Calibration& calibration);

}  // namespace faultlab::core
