#include "core/diagnosis/prediction_model.h"

#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

// Faster than this C8's pole has settled long before any reading; a smaller C8 would only cost
// squarings.
constexpr double kFastestPoleS = 2e-5;
// Speed in units of 100 rad/s and torque in mNm while exponentiating: keeps the rows alike.
constexpr double kSpeedScale = 100.0;
constexpr double kTorqueScale = 1e-3;

// A linear map of (z, i, w, d, u, torque) that leaves u and torque as they are, or its generator,
// without the zeros: z hears of u, d of nothing, i and w of all. Squarings of it cost a tenth of
// those of full matrices.
struct Motion {
  double zz = 0.0;
  double zu = 0.0;
  double dd = 0.0;
  Eigen::Matrix2d core = Eigen::Matrix2d::Zero();  ///< of (i, w); the others act on it
  Eigen::Vector2d from_z = Eigen::Vector2d::Zero();
  Eigen::Vector2d from_d = Eigen::Vector2d::Zero();
  Eigen::Vector2d from_u = Eigen::Vector2d::Zero();
  Eigen::Vector2d from_torque = Eigen::Vector2d::Zero();
};

Motion Scaled(const Motion& a, double factor) {
  return {a.zz * factor,
          a.zu * factor,
          a.dd * factor,
          a.core * factor,
          a.from_z * factor,
          a.from_d * factor,
          a.from_u * factor,
          a.from_torque * factor};
}

Motion PlusIdentity(Motion a) {
  a.zz += 1.0;
  a.dd += 1.0;
  a.core.diagonal().array() += 1.0;
  return a;
}

// a b; b leaves u and torque as they are, a may be a generator.
Motion Product(const Motion& a, const Motion& b) {
  Motion product;
  product.zz = a.zz * b.zz;
  product.zu = a.zz * b.zu + a.zu;
  product.dd = a.dd * b.dd;
  product.core.noalias() = a.core * b.core;
  product.from_z = a.core * b.from_z + a.from_z * b.zz;
  product.from_d = a.core * b.from_d + a.from_d * b.dd;
  product.from_u = a.core * b.from_u + a.from_z * b.zu + a.from_u;
  product.from_torque = a.core * b.from_torque + a.from_torque;
  return product;
}

double Norm(const Motion& a) {
  const Eigen::Vector2d rows = a.core.cwiseAbs().rowwise().sum() + a.from_z.cwiseAbs() +
                               a.from_d.cwiseAbs() + a.from_u.cwiseAbs() + a.from_torque.cwiseAbs();
  return std::max({std::abs(a.zz) + std::abs(a.zu), std::abs(a.dd), rows.maxCoeff()});
}

// exp(a t) by scaling and squaring of a Taylor polynomial: the motion is stable, its norm after
// scaling below 1/4, so degree 8 leaves less than 1e-11.
Motion Exponential(const Motion& a, double t) {
  const double norm = Norm(a) * t;
  const int squarings = std::max(0, static_cast<int>(std::ceil(std::log2(norm / 0.25))));
  const Motion step = Scaled(a, t * std::ldexp(1.0, -squarings));
  Motion sum = PlusIdentity(Scaled(step, 1.0 / 8.0));
  for (int n = 7; n >= 1; --n) sum = PlusIdentity(Scaled(Product(step, sum), 1.0 / n));
  for (int n = 0; n < squarings; ++n) sum = Product(sum, sum);
  return sum;
}

}  // namespace

PredictionModel MakePredictionModel(const RigParameters& rig,
                                    const NoiseLevel& noise,
                                    double period_s) {
  const PlantParameters& p = rig.plant;
  LAB_CHECK(rig.delta_s > 0.0 && rig.delta_s < period_s, rig.delta_s, period_s);
  const double re2 = p.re2_ohm();
  const double pole = std::max((re2 + p.r5_ohm) * p.c8_farad, kFastestPoleS);
  const double direct = p.r5_ohm / (re2 + p.r5_ohm);
  const double k = rig.gain();

  Motion a;
  a.zz = -1.0 / pole;
  a.zu = 1.0 / pole;
  a.dd = -1.0 / noise.friction_tau_s;
  a.core(0, 0) = -(p.ra_ohm + p.r1_ohm) / p.la_henry;
  a.core(0, 1) = -p.ke_v_per_rad_s * kSpeedScale / p.la_henry;
  a.core(1, 0) = p.kt_nm_per_a / p.j_kg_m2 / kSpeedScale;
  a.core(1, 1) = -p.b_nm_per_rad_s / p.j_kg_m2;
  a.from_z(0) = k * (1.0 - direct) / p.la_henry;
  a.from_u(0) = k * direct / p.la_henry;
  a.from_d(1) = -kTorqueScale / p.j_kg_m2 / kSpeedScale;
  a.from_torque = a.from_d;
  const Motion before = Exponential(a, period_s - rig.delta_s);
  const Motion after = Exponential(a, rig.delta_s);
  const Motion both = Product(after, before);

  const Eigen::Vector2d scale(1.0, kSpeedScale);
  PredictionModel m;
  m.phi.setZero();
  m.phi(0, 0) = both.zz;
  m.phi(3, 3) = both.dd;
  m.phi.block<2, 1>(1, 0) = scale.cwiseProduct(both.from_z);
  m.phi.block<2, 2>(1, 1) = scale.asDiagonal() * both.core * scale.cwiseInverse().asDiagonal();
  m.phi.block<2, 1>(1, 3) = scale.cwiseProduct(both.from_d) / kTorqueScale;
  // u of `before` is the old input: `after` adds nothing of its own to it.
  m.g_prev.setZero();
  m.g_prev(0) = after.zz * before.zu;
  m.g_prev.segment<2>(1) =
      scale.cwiseProduct(after.core * before.from_u + after.from_z * before.zu);
  m.g.setZero();
  m.g(0) = after.zu;
  m.g.segment<2>(1) = scale.cwiseProduct(after.from_u);
  m.g_torque.setZero();
  m.g_torque.segment<2>(1) = scale.cwiseProduct(both.from_torque) / kTorqueScale;
  m.c.setZero();
  m.c(0, 0) = k * (1.0 - direct);
  m.c(0, 1) = -p.r1_ohm;
  m.c(1, 1) = 1.0;
  m.c(2, 2) = 1.0;
  m.d = Eigen::Vector3d(k * direct, 0.0, 0.0);
  m.mc_nm = rig.mc_nm;
  m.torque_variance = noise.friction_nm * noise.friction_nm;
  m.torque_step_variance =
      m.torque_variance * (1.0 - std::exp(-2.0 * period_s / noise.friction_tau_s));
  m.reading_variance = {
      noise.um_v * noise.um_v, noise.ia_a * noise.ia_a, noise.w_rad_s * noise.w_rad_s};
  return m;
}

}  // namespace faultlab::core
