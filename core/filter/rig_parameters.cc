#include "core/filter/rig_parameters.h"

#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {

RigParameters WithOffsets(const RigParameters& base, const ParameterOffsets& q, double period_s) {
  const auto at = [&](Coordinate c) { return q[static_cast<std::size_t>(c)]; };
  RigParameters moved = base;
  moved.gain_factor *= std::exp(at(Coordinate::kGain));
  moved.plant.series_ohm *= std::exp(at(Coordinate::kSeries));
  moved.plant.ra_ohm *= std::exp(at(Coordinate::kRa));
  moved.j_factor *= std::exp(at(Coordinate::kJ));
  moved.plant.j_kg_m2 *= std::exp(at(Coordinate::kJ));
  moved.plant.b_nm_per_rad_s *= std::exp(at(Coordinate::kB));
  moved.plant.ke_v_per_rad_s *= std::exp(at(Coordinate::kKe));
  moved.plant.kt_nm_per_a *= std::exp(at(Coordinate::kKe));
  moved.plant.la_henry *= std::exp(at(Coordinate::kLa));
  moved.lag_factor *= std::exp(at(Coordinate::kLag));
  moved.mc_nm += at(Coordinate::kMc) * base.mc_unit_nm;
  moved.delta_s =
      std::clamp(moved.delta_s + at(Coordinate::kDelta) * (kDeltaUnitPeriods * period_s),
                 0.002 * period_s,
                 0.998 * period_s);
  return moved;
}

RigParameters WithOffsets(const RigParameters& base,
                          const Eigen::Ref<const Eigen::VectorXd>& q,
                          double period_s) {
  LAB_CHECK(IsCoordinateCount(q.size()), q.size());
  ParameterOffsets offsets{};
  for (int i = 0; i < q.size(); ++i) offsets[static_cast<std::size_t>(i)] = q(i);
  return WithOffsets(base, offsets, period_s);
}

int CoordinateOf(const ComponentInfo& part, const PlantParameters& plant) {
  switch (part.parameter) {
    case kSeries:
      return static_cast<int>(Coordinate::kSeries);
    case kRa:
      return static_cast<int>(Coordinate::kRa);
    case kKe:
      return static_cast<int>(Coordinate::kKe);
    case kJ:
      return static_cast<int>(Coordinate::kJ);
    case kB:
      return static_cast<int>(Coordinate::kB);
    default:
      break;
  }
  const int own = part.parameter - kMotorParameters;
  const bool has_a_say = own >= 0 && plant.structure->slope(plant.amplifier, own).gain != 0.0;
  return has_a_say ? static_cast<int>(Coordinate::kGain) : -1;
}

int GainPartOf(const PlantParameters& plant) {
  const Structure& structure = *plant.structure;
  int part = -1;
  for (int i = 0; i < structure.parameter_count() - kMotorParameters; ++i) {
    if (structure.slope(plant.amplifier, i).gain == 0.0) continue;
    if (part >= 0) return -1;
    part = kMotorParameters + i;
  }
  return part;
}

RigParameters ParametersOf(const Calibration& calibration) {
  return {calibration.nominal,
          calibration.gain_factor,
          calibration.delta_s,
          calibration.mc_nm,
          calibration.mc_unit_nm,
          GainPartOf(calibration.nominal),
          1.0,
          calibration.lag_factor};
}

ParameterOffsets WalkOf(const ModelError& error) {
  ParameterOffsets q{};
  for (std::size_t i = 0; i < kWarmingParts.size(); ++i) {
    q[static_cast<std::size_t>(kWarmingParts[i].coordinate)] = error.walk[i];
  }
  return q;
}

Eigen::MatrixXd CovarianceOf(const Calibration& calibration) {
  const auto n = std::lround(std::sqrt(static_cast<double>(calibration.covariance.size())));
  LAB_CHECK(IsCoordinateCount(n), n);
  const ParameterOffsets walk = WalkOf(calibration.model_error);
  Eigen::MatrixXd covariance =
      Eigen::Map<const Eigen::MatrixXd>(calibration.covariance.data(), n, n);
  covariance.diagonal() += Eigen::Map<const Eigen::VectorXd>(walk.data(), n).cwiseAbs2();
  return covariance;
}

double PassageNoise(double mc_nm, double j_kg_m2, double period_s) {
  constexpr double kShare = 0.3;
  return kShare * mc_nm / j_kg_m2 * period_s;
}

NoiseLevel NoiseOf(const Calibration& calibration) {
  return {calibration.um_noise_v,
          calibration.ia_noise_a,
          calibration.n_noise_rpm * RadPerSecondOfRpm(calibration.nominal.gear_ratio),
          calibration.friction_noise_nm,
          calibration.friction_tau_s,
          PassageNoise(calibration.mc_nm, calibration.nominal.j_kg_m2, calibration.period_s)};
}

Calibration WithHumAsNoise(const Calibration& calibration) {
  Calibration other = calibration;
  other.um_noise_v = std::hypot(calibration.um_noise_v, calibration.hum.um.rms());
  other.ia_noise_a = std::hypot(calibration.ia_noise_a, calibration.hum.ia.rms());
  other.hum = {};
  return other;
}

NoiseLevel DetectionNoiseOf(const Calibration& calibration) {
  constexpr double kReadingAllowance = 1.03;
  constexpr double kFrictionAllowance = 1.4;
  NoiseLevel noise = NoiseOf(calibration);
  noise.um_v *= kReadingAllowance;
  noise.ia_a *= kReadingAllowance;
  noise.w_rad_s *= kReadingAllowance;
  noise.friction_nm *= kFrictionAllowance;
  return noise;
}

}  // namespace faultlab::core
