#include "core/plant/coefficients.h"

#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {

ContinuousCoefficients MakeContinuous(const PlantParameters& p) {
  const double ke_kt = p.ke_v_per_rad_s * p.kt_nm_per_a;
  const double d = p.b_nm_per_rad_s * (p.ra_ohm + p.r1_ohm) + ke_kt;
  const double n = p.b_nm_per_rad_s * p.ra_ohm + ke_kt;
  LAB_CHECK(d > 0.0, d);
  const double k = p.gain();
  ContinuousCoefficients c;
  c.b0 = k * n / d;
  c.b1 = k * (p.j_kg_m2 * p.ra_ohm + p.c8_farad * p.r5_ohm * n) / d;
  c.a12 = p.j_kg_m2 * (p.ra_ohm + p.r1_ohm) / d;
  c.a1 = c.a12 + p.c8_farad * (p.r5_ohm + p.re2_ohm());
  c.b02 = p.r1_ohm * p.ke_v_per_rad_s / d;
  return c;
}

DiscreteCoefficients Discretise(const ContinuousCoefficients& c, double period_s, double delta_s) {
  LAB_CHECK(c.a1 > 0.0 && period_s > 0.0, c.a1, period_s);
  const double e = std::exp(-period_s / c.a1);
  DiscreteCoefficients d;
  d.a1d = -e;
  d.b0d = c.b0 - (c.b0 - c.b1 / c.a1) * std::exp(-delta_s / c.a1);
  d.b1d = c.b0 * (1.0 - e) - d.b0d;
  return d;
}

std::optional<ContinuousCoefficients> MakeContinuous(const DiscreteCoefficients& d,
                                                     double period_s,
                                                     double delta_s) {
  if (!(d.a1d < 0.0 && d.a1d > -1.0)) {
    return std::nullopt;
  }
  ContinuousCoefficients c;
  c.a1 = -period_s / std::log(-d.a1d);
  c.b0 = (d.b0d + d.b1d) / (1.0 + d.a1d);
  c.b1 = c.a1 * (c.b0 - (c.b0 - d.b0d) * std::exp(delta_s / c.a1));
  return c;
}

CoefficientJacobian ContinuousJacobian(const PlantParameters& p) {
  const double ke_kt = p.ke_v_per_rad_s * p.kt_nm_per_a;
  const double b = p.b_nm_per_rad_s;
  const double j = p.j_kg_m2;
  const double ra = p.ra_ohm;
  const double r = ra + p.r1_ohm;
  const double d = b * r + ke_kt;
  const double n = b * ra + ke_kt;
  const double q = j * ra + p.c8_farad * p.r5_ohm * n;  // b1 = k q / d
  const double k = p.gain();
  const double re1 = p.re1_ohm();
  const double dk_dr9 = -p.re2_ohm() / (p.r9_ohm * p.r9_ohm);  // 1/Re1 = 1/R9 + 1/R10
  const double dk_dr12 = 1.0 / re1;
  const double c8_r5 = p.c8_farad * p.r5_ohm;

  CoefficientJacobian jacobian;
  const auto column = [&jacobian](Component component) { return jacobian.col(Index(component)); };
  column(Component::kR1) << -k * n * b / (d * d), -k * q * b / (d * d), j * ke_kt / (d * d);
  column(Component::kR9) << dk_dr9 * n / d, dk_dr9 * q / d, 0.0;
  column(Component::kR12) << dk_dr12 * n / d, dk_dr12 * q / d, p.c8_farad;
  column(Component::kC8) << 0.0, k * p.r5_ohm * n / d, p.r5_ohm + p.re2_ohm();
  column(Component::kRa) << k * b * (d - n) / (d * d), k * ((j + c8_r5 * b) * d - q * b) / (d * d),
      j * ke_kt / (d * d);
  column(Component::kJ) << 0.0, k * ra / d, r / d;
  column(Component::kB) << k * (ra * d - n * r) / (d * d), k * (c8_r5 * ra * d - q * r) / (d * d),
      -j * r * r / (d * d);
  return jacobian;
}

CoefficientJacobian DiscreteJacobian(const PlantParameters& parameters,
                                     double period_s,
                                     double delta_s) {
  const ContinuousCoefficients c = MakeContinuous(parameters);
  const double a1_squared = c.a1 * c.a1;
  const double e = std::exp(-period_s / c.a1);
  const double e_delta = std::exp(-delta_s / c.a1);
  const double de_da1 = e * period_s / a1_squared;
  const double de_delta_da1 = e_delta * delta_s / a1_squared;

  Eigen::Matrix3d chain;  // d(b0d, b1d, a1d)/d(b0, b1, a1)
  chain.row(0) << 1.0 - e_delta, e_delta / c.a1,
      -c.b1 / a1_squared * e_delta - (c.b0 - c.b1 / c.a1) * de_delta_da1;
  chain.row(1) << 1.0 - e, 0.0, -c.b0 * de_da1;
  chain.row(1) -= chain.row(0);
  chain.row(2) << 0.0, 0.0, -de_da1;
  return chain * ContinuousJacobian(parameters);
}

}  // namespace faultlab::core
