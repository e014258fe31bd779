#include "core/plant/coefficients.h"

#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {

ContinuousCoefficients MakeContinuous(const PlantParameters& p) {
  const double ke_kt = p.ke_v_per_rad_s * p.kt_nm_per_a;
  const double d = p.b_nm_per_rad_s * (p.ra_ohm + p.series_ohm) + ke_kt;
  LAB_CHECK(d > 0.0, d);
  const AmplifierResponse response = p.response();
  const double k = response.gain;
  ContinuousCoefficients c;
  c.a12 = p.j_kg_m2 * (p.ra_ohm + p.series_ohm) / d;
  c.a1 = c.a12 + response.lag_s;
  if (p.structure->estimated == EstimatedChannel::kIa) {
    c.b0 = k * p.b_nm_per_rad_s / d;
    c.b1 = k * (p.j_kg_m2 + response.lead_s() * p.b_nm_per_rad_s) / d;
    c.b02 = -p.ke_v_per_rad_s / d;
    return c;
  }
  const double n = p.b_nm_per_rad_s * p.ra_ohm + ke_kt;
  c.b0 = k * n / d;
  c.b1 = k * (p.j_kg_m2 * p.ra_ohm + response.lead_s() * n) / d;
  c.b02 = p.series_ohm * p.ke_v_per_rad_s / d;
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

namespace {

/// The terms of the coefficients.
struct Parts {
  double ra, r, b, j, ke, kt, d;
  double q;  ///< b0 = k q / d
  double p;  ///< b1 = k (p + lead q) / d
  AmplifierResponse response;
};

Parts PartsOf(const PlantParameters& plant) {
  Parts s{};
  s.ra = plant.ra_ohm;
  s.r = plant.ra_ohm + plant.series_ohm;
  s.b = plant.b_nm_per_rad_s;
  s.j = plant.j_kg_m2;
  s.ke = plant.ke_v_per_rad_s;
  s.kt = plant.kt_nm_per_a;
  s.d = s.b * s.r + s.ke * s.kt;
  const bool current = plant.structure->estimated == EstimatedChannel::kIa;
  s.q = current ? s.b : s.b * s.ra + s.ke * s.kt;
  s.p = current ? s.j : s.j * s.ra;
  s.response = plant.response();
  return s;
}

/// d(d, q, p, J R)/d(a motor parameter).
struct MotorSlope {
  double d = 0.0;
  double q = 0.0;
  double p = 0.0;
  double jr = 0.0;

  void Add(double factor, const MotorSlope& other) {
    d += factor * other.d;
    q += factor * other.q;
    p += factor * other.p;
    jr += factor * other.jr;
  }
};

MotorSlope SlopeOf(const Parts& s, bool current, int parameter) {
  switch (parameter) {
    case kSeries:
      return {s.b, 0.0, 0.0, s.j};
    case kRa:
      return {s.b, current ? 0.0 : s.b, current ? 0.0 : s.j, s.j};
    case kKe:
      return {s.kt, current ? 0.0 : s.kt, 0.0, 0.0};
    case kKt:
      return {s.ke, current ? 0.0 : s.ke, 0.0, 0.0};
    case kJ:
      return {0.0, 0.0, current ? 1.0 : s.ra, s.r};
    case kB:
      return {s.r, current ? 1.0 : s.ra, 0.0, 0.0};
    default:
      return {};
  }
}

}  // namespace

CoefficientJacobian ContinuousJacobian(const PlantParameters& plant,
                                       std::span<const Component> components) {
  const Parts s = PartsOf(plant);
  const bool current = plant.structure->estimated == EstimatedChannel::kIa;
  const double k = s.response.gain;
  const double lead = s.response.lead_s();
  const double b1 = s.p + lead * s.q;  // b1 = k b1 / d
  CoefficientJacobian jacobian(3, static_cast<Eigen::Index>(components.size()));
  Eigen::Index column = 0;
  for (const Component component : components) {
    const ComponentInfo& info = component.info();
    const int parameter = info.parameter;
    if (parameter < kMotorParameters) {
      MotorSlope m = SlopeOf(s, current, parameter);
      if (info.coupled >= 0) m.Add(info.coupled_ratio, SlopeOf(s, current, info.coupled));
      jacobian.col(column++) << k * (m.q * s.d - s.q * m.d) / (s.d * s.d),
          k * ((m.p + lead * m.q) * s.d - b1 * m.d) / (s.d * s.d),
          (m.jr * s.d - s.j * s.r * m.d) / (s.d * s.d);
    } else {
      const ResponseSlope a = plant.structure->slope(plant.amplifier, parameter - kMotorParameters);
      jacobian.col(column++) << a.gain * s.q / s.d, a.gain * b1 / s.d + k * a.lead_s * s.q / s.d,
          a.lag_s;
    }
  }
  return jacobian;
}

CoefficientJacobian DiscreteJacobian(const PlantParameters& parameters,
                                     std::span<const Component> components,
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
  return chain * ContinuousJacobian(parameters, components);
}

}  // namespace faultlab::core
