#include "core/diagnosis/prediction_model.h"

#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

using Augmented = Eigen::Matrix<double, 6, 6>;  // x, u, torque

// exp(a t) by scaling and squaring of a Taylor polynomial: the matrix is stable and block
// triangular, the norm after scaling below 1/4, so degree 8 leaves less than 1e-11.
Augmented Exponential(const Augmented& a, double t) {
  const double norm = (a * t).cwiseAbs().rowwise().sum().maxCoeff();
  const int squarings = std::max(0, static_cast<int>(std::ceil(std::log2(norm / 0.25))));
  const Augmented step = a * (t * std::ldexp(1.0, -squarings));
  Augmented sum = Augmented::Identity() + step / 8.0;
  for (int n = 7; n >= 1; --n) {
    const Augmented product = step * sum;
    sum = Augmented::Identity() + product / n;
  }
  for (int n = 0; n < squarings; ++n) {
    const Augmented square = sum * sum;
    sum = square;
  }
  return sum;
}

// Faster than this C8's pole has settled long before any reading; a smaller C8 would only cost
// squarings.
constexpr double kFastestPoleS = 2e-5;
// Speed in units of 100 rad/s while exponentiating: keeps the rows of the matrix alike.
constexpr double kSpeedScale = 100.0;
constexpr double kTorqueScale = 1e-3;

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

  Augmented a = Augmented::Zero();
  a(0, 0) = -1.0 / pole;
  a(0, 4) = 1.0 / pole;
  a(1, 0) = k * (1.0 - direct) / p.la_henry;
  a(1, 4) = k * direct / p.la_henry;
  a(1, 1) = -(p.ra_ohm + p.r1_ohm) / p.la_henry;
  a(1, 2) = -p.ke_v_per_rad_s * kSpeedScale / p.la_henry;
  a(2, 1) = p.kt_nm_per_a / p.j_kg_m2 / kSpeedScale;
  a(2, 2) = -p.b_nm_per_rad_s / p.j_kg_m2;
  a(2, 3) = -kTorqueScale / p.j_kg_m2 / kSpeedScale;
  a(2, 5) = a(2, 3);
  a(3, 3) = -1.0 / noise.friction_tau_s;
  const Augmented before = Exponential(a, period_s - rig.delta_s);
  const Augmented after = Exponential(a, rig.delta_s);

  // u of `before` is the old input: its column is not carried through the input rows of `after`.
  const Eigen::Vector4d scale(1.0, 1.0, kSpeedScale, kTorqueScale);
  const Eigen::Matrix4d after_x = after.topLeftCorner<4, 4>();
  PredictionModel m;
  m.phi = scale.asDiagonal() * (after_x * before.topLeftCorner<4, 4>()) *
          scale.cwiseInverse().asDiagonal();
  m.g_prev = scale.asDiagonal() * (after_x * before.col(4).head<4>());
  m.g = scale.asDiagonal() * after.col(4).head<4>();
  m.g_torque = scale.asDiagonal() * (after_x * before.col(5).head<4>() + after.col(5).head<4>()) /
               kTorqueScale;
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
