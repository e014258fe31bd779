#include "core/plant/propagator.h"

#include <Eigen/LU>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

// Rows v, i, w, angle, u, M: the drive u and the torque M are added as constant states.
constexpr int kSize = 6;
using Augmented = Eigen::Matrix<double, kSize, kSize>;

// Pade [6/6] of exp: below this 1-norm its backward error is under the double's unit roundoff
// (Higham 2005, table 2.3, theta_6 = 0.54).
constexpr double kPadeNorm = 0.5;
constexpr std::array<double, 7> kPade = {
    1.0, 1.0 / 2.0, 5.0 / 44.0, 1.0 / 66.0, 1.0 / 792.0, 1.0 / 15840.0, 1.0 / 665280.0};

Augmented Exponential(const Augmented& matrix) {
  const double norm = matrix.cwiseAbs().colwise().sum().maxCoeff();
  LAB_CHECK(std::isfinite(norm), norm);
  int squarings = 0;
  if (norm > kPadeNorm) {
    squarings = static_cast<int>(std::ceil(std::log2(norm / kPadeNorm)));
  }
  const Augmented a = matrix * std::ldexp(1.0, -squarings);
  const Augmented a2 = a * a;
  const Augmented a4 = a2 * a2;
  const Augmented a6 = a4 * a2;
  const Augmented one = Augmented::Identity();
  const Augmented even = kPade[0] * one + kPade[2] * a2 + kPade[4] * a4 + kPade[6] * a6;
  const Augmented odd = a * (kPade[1] * one + kPade[3] * a2 + kPade[5] * a4);
  Augmented result = (even - odd).partialPivLu().solve(even + odd);
  for (int i = 0; i < squarings; ++i) {
    const Augmented square = result * result;
    result = square;
  }
  return result;
}

}  // namespace

LinearSystem MakeLinearSystem(const PlantParameters& p, double gain_error, LinearRegime regime) {
  LinearSystem system;
  system.a.setZero();
  system.b.setZero();
  system.g.setZero();
  const AmplifierResponse response = p.response();
  const double lead_s = response.lead_s();
  const double r = p.ra_ohm + p.series_ohm;

  // Rows v and i: they depend on what holds the output voltage.
  double output_from_v = 0.0;
  double output_from_u = 0.0;
  switch (regime.output) {
    case LinearRegime::Output::kAmplifier:
      output_from_v = 1.0 - response.direct;
      output_from_u = response.gain * response.direct * (1.0 + gain_error);
      break;
    case LinearRegime::Output::kClamped:
      output_from_u = 1.0;
      break;
    case LinearRegime::Output::kCurrent:
      break;
  }
  if (regime.output == LinearRegime::Output::kCurrent) {
    // i is held and v is constant; the drive u is the current itself.
    if (regime.turning) {
      system.b(2) = p.kt_nm_per_a / p.j_kg_m2;
    }
  } else {
    system.a(0, 0) = (output_from_v - 1.0) / lead_s;
    system.b(0) = output_from_u / lead_s;
    system.a(1, 0) = output_from_v / p.la_henry;
    system.b(1) = output_from_u / p.la_henry;
    system.a(1, 1) = -r / p.la_henry;
    if (regime.turning) {
      system.a(1, 2) = -p.ke_v_per_rad_s / p.la_henry;
      system.a(2, 1) = p.kt_nm_per_a / p.j_kg_m2;
    }
  }
  if (regime.turning) {
    system.a(2, 2) = -p.b_nm_per_rad_s / p.j_kg_m2;
    system.g(2) = -1.0 / p.j_kg_m2;
  }
  return system;
}

Propagator MakePropagator(const LinearSystem& system, double step_s) {
  // The friction torque enters in mNm and the angle is the integral of w: these units keep the
  // norm, and therefore the number of squarings, as small as the dynamics allow.
  constexpr double kTorqueUnit = 1e-3;
  Augmented matrix = Augmented::Zero();
  matrix.block<3, 3>(0, 0) = system.a;
  matrix(3, 2) = 1.0;
  matrix.block<3, 1>(0, 4) = system.b;
  matrix.block<3, 1>(0, 5) = system.g * kTorqueUnit;
  const Augmented e = Exponential(matrix * step_s);
  Propagator propagator;
  propagator.phi = e.block<3, 3>(0, 0);
  propagator.gamma_u = e.block<3, 1>(0, 4);
  propagator.gamma_m = e.block<3, 1>(0, 5) / kTorqueUnit;
  propagator.angle_x = e.block<1, 3>(3, 0).transpose();
  propagator.angle_u = e(3, 4);
  propagator.angle_m = e(3, 5) / kTorqueUnit;
  return propagator;
}

void PropagatorCache::Reset(const PlantParameters& parameters, double gain_error) {
  parameters_ = parameters;
  gain_error_ = gain_error;
  for (Entry& entry : entries_) {
    entry.step_s = 0.0;
  }
  next_ = 0;
  const double damping = (parameters.ra_ohm + parameters.series_ohm) / parameters.la_henry -
                         parameters.b_nm_per_rad_s / parameters.j_kg_m2;
  const double coupling = parameters.ke_v_per_rad_s * parameters.kt_nm_per_a /
                          (parameters.la_henry * parameters.j_kg_m2);
  oscillates_ = damping * damping < 4.0 * coupling;
}

const Propagator& PropagatorCache::Get(LinearRegime regime, double step_s) {
  for (const Entry& entry : entries_) {
    if (entry.step_s == step_s && entry.regime == regime) {
      return entry.propagator;
    }
  }
  Entry& entry = entries_[next_];
  next_ = (next_ + 1) % entries_.size();
  entry.regime = regime;
  entry.step_s = step_s;
  entry.propagator = MakePropagator(MakeLinearSystem(parameters_, gain_error_, regime), step_s);
  return entry.propagator;
}

Propagator PropagatorCache::Once(LinearRegime regime, double step_s) const {
  return MakePropagator(MakeLinearSystem(parameters_, gain_error_, regime), step_s);
}

}  // namespace faultlab::core
