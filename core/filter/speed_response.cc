#include "core/filter/speed_response.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

/// Gain (rpm/V), time constant (s) and friction (rpm).
Eigen::Vector3d NumbersOf(const RigParameters& rig) {
  const SpeedNumbers numbers = SpeedNumbersOf(rig);
  const double rpm = 1.0 / RadPerSecondOfRpm(rig.plant.gear_ratio);
  return {rpm * numbers.gain, numbers.time_constant_s, rpm * numbers.friction};
}

}  // namespace

SpeedNumbers SpeedNumbersOf(const RigParameters& rig) {
  const PlantParameters& p = rig.plant;
  const double r = p.ra_ohm + p.series_ohm;
  const double d = p.b_nm_per_rad_s * r + p.ke_v_per_rad_s * p.kt_nm_per_a;
  return {.gain = rig.gain() * p.kt_nm_per_a / d,
          .time_constant_s = p.j_kg_m2 * r / d + rig.lag_factor * p.response().lag_s,
          .friction = r * rig.mc_nm / d};
}

SpeedResponse SpeedResponseOf(const std::function<RigParameters(const Eigen::VectorXd&)>& rig_at,
                              const Eigen::VectorXd& point,
                              const Eigen::MatrixXd& covariance) {
  constexpr double kStep = 1e-4;  // of coordinates that are logarithms or of their size
  const Eigen::Vector3d at = NumbersOf(rig_at(point));
  Eigen::MatrixXd slopes(3, point.size());
  for (Eigen::Index i = 0; i < point.size(); ++i) {
    Eigen::VectorXd up = point;
    Eigen::VectorXd down = point;
    up(i) += kStep;
    down(i) -= kStep;
    slopes.col(i) = (NumbersOf(rig_at(up)) - NumbersOf(rig_at(down))) / (2.0 * kStep);
  }
  const Eigen::Vector3d variances = (slopes * covariance * slopes.transpose()).diagonal();
  const auto measured = [&](Eigen::Index i) {
    return Measured{at(i), std::sqrt(std::max(0.0, variances(i)))};
  };
  return {measured(0), measured(1), measured(2)};
}

SpeedResponse SpeedResponseOf(const Calibration& calibration) {
  const RigParameters rig = ParametersOf(calibration);
  Eigen::MatrixXd covariance = CovarianceOf(calibration);
  const Eigen::Index n = covariance.rows();
  if (calibration.model_covariance.size() == calibration.covariance.size()) {
    covariance += Eigen::Map<const Eigen::MatrixXd>(calibration.model_covariance.data(), n, n);
  }
  const auto rig_at = [&](const Eigen::VectorXd& q) {
    return WithOffsets(rig, q, calibration.period_s);
  };
  return SpeedResponseOf(rig_at, Eigen::VectorXd::Zero(n), covariance);
}

}  // namespace faultlab::core
