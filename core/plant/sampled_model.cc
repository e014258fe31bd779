#include "core/plant/sampled_model.h"

#include <Eigen/LU>
#include <algorithm>

#include "core/numerics/rest_passage.h"
#include "core/plant/propagator.h"
#include "core/types/check.h"

namespace faultlab::core {

Eigen::Vector3d SampledModel::SteadyState(double uc_v, double mc_nm) const {
  const Eigen::Matrix3d system = Eigen::Matrix3d::Identity() - phi;
  return system.partialPivLu().solve(gamma_u * uc_v + gamma_m * mc_nm);
}

SampledModel MakeSampledModel(const PlantParameters& p, double period_s, double delta_s) {
  LAB_CHECK(delta_s >= 0.0 && delta_s < period_s, delta_s, period_s);
  const LinearSystem system = MakeLinearSystem(p, 0.0, LinearRegime{});
  const Propagator whole = MakePropagator(system, period_s);
  const Propagator part = MakePropagator(system, delta_s);

  // Outputs (um, ia, w) at one instant: um = Uout - Rs i, Uout as in MakeLinearSystem.
  const AmplifierResponse response = p.response();
  Eigen::Matrix3d instant;
  instant << 1.0 - response.direct, -p.series_ohm, 0.0,  //
      0.0, 1.0, 0.0,                                     //
      0.0, 0.0, 1.0;

  SampledModel model;
  model.phi = whole.phi;
  model.gamma_u = whole.gamma_u;
  model.gamma_m = whole.gamma_m;
  model.c = instant * part.phi;
  model.d_u = instant * part.gamma_u;
  model.d_u(0) += response.gain * response.direct;
  model.d_m = instant * part.gamma_m;
  return model;
}

std::vector<double> FrictionDirections(const SampledModel& model,
                                       std::span<const double> uc_v,
                                       double mc_nm) {
  if (uc_v.empty()) return {};
  const auto [least, most] = std::ranges::minmax(uc_v);
  if (!(least < 0.0 && most > 0.0)) return {};
  std::vector<double> directions(uc_v.size());
  const double kept = std::clamp(model.phi(2, 2), 0.0, 1.0);
  const double held = -model.gamma_m(2) * mc_nm;
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < uc_v.size(); ++k) {
    const Eigen::Vector3d free = model.phi * x + model.gamma_u * uc_v[k];
    directions[k] = MeanDirection(x(2), free(2), held, kept);
    x = free + model.gamma_m * (mc_nm * directions[k]);
  }
  return directions;
}

Eigen::Vector3d Simulate(const SampledModel& model,
                         int row,
                         std::span<const double> uc_v,
                         double mc_nm,
                         const Eigen::Vector3d& x0,
                         std::span<double> y,
                         std::span<const double> directions) {
  LAB_CHECK(uc_v.size() == y.size(), uc_v.size(), y.size());
  LAB_CHECK(directions.empty() || directions.size() == uc_v.size(), directions.size());
  Eigen::Vector3d x = x0;
  Eigen::Vector3d from_friction = model.gamma_m * mc_nm;
  double y_from_friction = model.d_m(row) * mc_nm;
  for (std::size_t k = 0; k < uc_v.size(); ++k) {
    if (!directions.empty()) {
      from_friction = model.gamma_m * (mc_nm * directions[k]);
      y_from_friction = model.d_m(row) * mc_nm * directions[k];
    }
    y[k] = model.c.row(row).dot(x) + model.d_u(row) * uc_v[k] + y_from_friction;
    const Eigen::Vector3d next = model.phi * x + model.gamma_u * uc_v[k] + from_friction;
    x = next;
  }
  return x;
}

}  // namespace faultlab::core
