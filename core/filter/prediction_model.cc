#include "core/filter/prediction_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/numerics/lanes.h"
#include "core/numerics/rest_passage.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

// Shortest lag used: such a lag settles long before any reading, and a shorter one would only need
// more squarings.
constexpr double kFastestPoleS = 2e-5;
// Units of speed (100 rad/s) and torque (mNm) while exponentiating, so that the rows have similar
// size.
constexpr double kSpeedScale = 100.0;
constexpr double kTorqueScale = 1e-3;
constexpr double kReferencePeriodS = 0.01;
// Of a motor so fast that its speed overshoots.
constexpr double kKeptMin = 0.01;

// A linear map of (z, i, w, d, u, torque) that leaves u and torque as they are, or the generator of
// such a map, stored without the zeros. Nonzero couplings: z <- u; d is decoupled; i and w <- all.
// Two maps side by side: for the part of the period before the edge of u, and for the part after
// it.
struct Motions {
  Lanes2 zz{}, zu{}, dd{};
  Lanes2 ii{}, iw{}, wi{}, ww{};
  Lanes2 iz{}, wz{}, id{}, wd{}, iu{}, wu{}, im{}, wm{};  ///< m: torque

  [[gnu::always_inline]] Motions Scaled(Lanes2 f) const {
    return {zz * f,
            zu * f,
            dd * f,
            ii * f,
            iw * f,
            wi * f,
            ww * f,
            iz * f,
            wz * f,
            id * f,
            wd * f,
            iu * f,
            wu * f,
            im * f,
            wm * f};
  }

  [[gnu::always_inline]] void AddIdentity() {
    zz += 1.0;
    dd += 1.0;
    ii += 1.0;
    ww += 1.0;
  }
};

// The product a b. b leaves u and torque as they are; a may be a generator.
[[gnu::always_inline]] inline Motions Product(const Motions& a, const Motions& b) {
  return {a.zz * b.zz,
          a.zz * b.zu + a.zu,
          a.dd * b.dd,
          a.ii * b.ii + a.iw * b.wi,
          a.ii * b.iw + a.iw * b.ww,
          a.wi * b.ii + a.ww * b.wi,
          a.wi * b.iw + a.ww * b.ww,
          a.ii * b.iz + a.iw * b.wz + a.iz * b.zz,
          a.wi * b.iz + a.ww * b.wz + a.wz * b.zz,
          a.ii * b.id + a.iw * b.wd + a.id * b.dd,
          a.wi * b.id + a.ww * b.wd + a.wd * b.dd,
          a.ii * b.iu + a.iw * b.wu + a.iz * b.zu + a.iu,
          a.wi * b.iu + a.ww * b.wu + a.wz * b.zu + a.wu,
          a.ii * b.im + a.iw * b.wm + a.im,
          a.wi * b.im + a.ww * b.wm + a.wm};
}

double Norm(const Motions& a) {
  const auto abs = [](Lanes2 value) { return std::abs(value[0]); };
  return std::max({abs(a.zz) + abs(a.zu),
                   abs(a.dd),
                   abs(a.ii) + abs(a.iw) + abs(a.iz) + abs(a.id) + abs(a.iu) + abs(a.im),
                   abs(a.wi) + abs(a.ww) + abs(a.wz) + abs(a.wd) + abs(a.wu) + abs(a.wm)});
}

// exp(a t) by scaling and squaring of a Taylor polynomial. The system is stable and its norm after
// scaling is below 1/4, so the error of degree 8 is below 1e-11.
Motions Exponential(const Motions& a, Lanes2 t) {
  const double norm = Norm(a) * std::max(t[0], t[1]);
  const int squarings = std::max(0, static_cast<int>(std::ceil(std::log2(norm / 0.25))));
  const Motions step = a.Scaled(t * std::ldexp(1.0, -squarings));
  Motions sum = step.Scaled(Lanes2{} + 1.0 / 8.0);
  sum.AddIdentity();
  for (int n = 7; n >= 1; --n) {
    sum = Product(step, sum).Scaled(Lanes2{} + 1.0 / n);
    sum.AddIdentity();
  }
  for (int n = 0; n < squarings; ++n) sum = Product(sum, sum);
  return sum;
}

}  // namespace

Eigen::Vector4d TurningState(const PredictionModel& m, double u) {
  const Eigen::Matrix4d a = Eigen::Matrix4d::Identity() - m.phi;
  const Eigen::Vector4d b =
      (m.g_prev + m.g) * m.Limited(u) + m.g_torque * std::copysign(m.mc_nm, u);
  const Eigen::Vector4d x = a.partialPivLu().solve(b);
  return x.allFinite() ? x : Eigen::Vector4d::Zero();
}

Eigen::Vector4d StepHeld(const PredictionModel& m,
                         const Eigen::Vector4d& x,
                         double u_prev,
                         double u,
                         FrictionStep& friction) {
  const Eigen::Vector4d torque = m.phi.col(3) * x(3) + m.g_torque * m.mc_nm;
  Eigen::Vector4d next = m.phi.leftCols<3>() * x.head<3>() + m.g_prev * u_prev + m.g * u;
  ActFriction(x(2),
              m.edge_w.head<3>().dot(x.head<3>()) + m.edge_w_u * u_prev,
              next(2),
              std::max(-(m.edge_w(3) * x(3) + m.edge_w_torque * m.mc_nm), 0.0),
              std::max(-torque(2), 0.0),
              m.edge_kept,
              m.later_kept,
              friction.direction,
              friction.passage_variance);
  friction.passage_variance *= m.passage_variance;
  next.head<3>() += friction.direction * torque.head<3>();
  next(3) = torque(3);
  return next;
}

PredictionModel MakePredictionModel(const RigParameters& rig,
                                    const NoiseLevel& noise,
                                    double period_s) {
  const PlantParameters& p = rig.plant;
  LAB_CHECK(rig.delta_s > 0.0 && rig.delta_s < period_s, rig.delta_s, period_s);
  const AmplifierResponse response = p.response();
  const double pole = std::max(rig.lag_factor * response.lag_s, kFastestPoleS);
  const double direct = std::min(1.0, rig.direct_factor * response.direct);
  const double k = rig.gain_factor * response.gain;

  const Lanes2 both{1.0, 1.0};
  Motions a;
  a.zz = both * (-1.0 / pole);
  a.zu = both * (1.0 / pole);
  a.dd = both * (-1.0 / noise.friction_tau_s);
  a.ii = both * (-(p.ra_ohm + p.series_ohm) / p.la_henry);
  a.iw = both * (-p.ke_v_per_rad_s * kSpeedScale / p.la_henry);
  a.wi = both * (p.kt_nm_per_a / p.j_kg_m2 / kSpeedScale);
  a.ww = both * (-p.b_nm_per_rad_s / p.j_kg_m2);
  a.iz = both * (k * (1.0 - direct) / p.la_henry);
  a.iu = both * (k * direct / p.la_henry);
  a.wd = both * (-kTorqueScale / p.j_kg_m2 / kSpeedScale);
  a.wm = a.wd;
  const Motions e = Exponential(a, Lanes2{period_s - rig.delta_s, rig.delta_s});

  // Lane 0 is the part before the edge, lane 1 the part after it. In lane 0 u is the old input;
  // lane 1 only propagates what lane 0 has made of it.
  PredictionModel m;
  m.phi.setZero();
  m.phi(0, 0) = e.zz[1] * e.zz[0];
  m.phi(1, 0) = e.ii[1] * e.iz[0] + e.iw[1] * e.wz[0] + e.iz[1] * e.zz[0];
  m.phi(2, 0) = kSpeedScale * (e.wi[1] * e.iz[0] + e.ww[1] * e.wz[0] + e.wz[1] * e.zz[0]);
  m.phi(1, 1) = e.ii[1] * e.ii[0] + e.iw[1] * e.wi[0];
  m.phi(2, 1) = kSpeedScale * (e.wi[1] * e.ii[0] + e.ww[1] * e.wi[0]);
  m.phi(1, 2) = (e.ii[1] * e.iw[0] + e.iw[1] * e.ww[0]) / kSpeedScale;
  m.phi(2, 2) = e.wi[1] * e.iw[0] + e.ww[1] * e.ww[0];
  m.phi(1, 3) = (e.ii[1] * e.id[0] + e.iw[1] * e.wd[0] + e.id[1] * e.dd[0]) / kTorqueScale;
  m.phi(2, 3) =
      (e.wi[1] * e.id[0] + e.ww[1] * e.wd[0] + e.wd[1] * e.dd[0]) * (kSpeedScale / kTorqueScale);
  m.phi(3, 3) = e.dd[1] * e.dd[0];
  m.g_prev(0) = e.zz[1] * e.zu[0];
  m.g_prev(1) = e.ii[1] * e.iu[0] + e.iw[1] * e.wu[0] + e.iz[1] * e.zu[0];
  m.g_prev(2) = kSpeedScale * (e.wi[1] * e.iu[0] + e.ww[1] * e.wu[0] + e.wz[1] * e.zu[0]);
  m.g_prev(3) = 0.0;
  m.g = Eigen::Vector4d(e.zu[1], e.iu[1], kSpeedScale * e.wu[1], 0.0);
  m.g_torque(0) = 0.0;
  m.g_torque(1) = (e.ii[1] * e.im[0] + e.iw[1] * e.wm[0] + e.im[1]) / kTorqueScale;
  m.g_torque(2) = (e.wi[1] * e.im[0] + e.ww[1] * e.wm[0] + e.wm[1]) * (kSpeedScale / kTorqueScale);
  m.g_torque(3) = 0.0;
  m.edge_w = Eigen::Vector4d(kSpeedScale * e.wz[0],
                             kSpeedScale * e.wi[0],
                             e.ww[0],
                             e.wd[0] * (kSpeedScale / kTorqueScale));
  m.edge_w_u = kSpeedScale * e.wu[0];
  m.edge_w_torque = e.wm[0] * (kSpeedScale / kTorqueScale);
  m.edge_kept = std::clamp(e.ww[0], kKeptMin, 1.0);
  m.later_kept = std::clamp(e.ww[1], kKeptMin, 1.0);
  m.c.setZero();
  m.c(0, 0) = k * (1.0 - direct);
  m.c(0, 1) = -p.series_ohm;
  m.c(1, 1) = 1.0;
  m.c(2, 2) = 1.0;
  m.d = Eigen::Vector3d(k * direct, 0.0, 0.0);
  m.zeros = rig.zeros;
  m.scales = rig.scales;
  m.mc_nm = rig.mc_nm;
  m.torque_variance = noise.friction_nm * noise.friction_nm;
  m.torque_step_variance =
      m.torque_variance * (1.0 - std::exp(-2.0 * period_s / noise.friction_tau_s));
  m.passage_variance = noise.passage_rad_s * noise.passage_rad_s;
  m.reading_variance = {
      noise.um_v * noise.um_v, noise.ia_a * noise.ia_a, noise.w_rad_s * noise.w_rad_s};
  m.creep_rad_s = p.range.creep_rad_s;
  m.u_min = p.range.output_min_v / k;
  m.u_max = p.range.output_max_v / k;
  m.start_sd = {p.range.input_v, p.range.current_a, p.range.speed_rad_s};
  m.density = std::max(1.0, kReferencePeriodS / period_s);
  return m;
}

}  // namespace faultlab::core
