#include "core/plant/coefficients.h"

#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {

double ReadingPerOutput(const PlantParameters& p) {
  const bool speed = p.structure->estimated == EstimatedChannel::kSpeed;
  return speed ? 1.0 / RadPerSecondOfRpm(p.gear_ratio) : 1.0;
}

ContinuousCoefficients MakeContinuous(const PlantParameters& p) {
  const double ke_kt = p.ke_v_per_rad_s * p.kt_nm_per_a;
  const double d = p.b_nm_per_rad_s * (p.ra_ohm + p.series_ohm) + ke_kt;
  LAB_CHECK(d > 0.0, d);
  const AmplifierResponse response = p.response();
  const double k = response.gain;
  ContinuousCoefficients c;
  c.a12 = p.j_kg_m2 * (p.ra_ohm + p.series_ohm) / d;
  c.a1 = c.a12 + response.lag_s;
  switch (p.structure->estimated) {
    case EstimatedChannel::kUm: {
      const double n = p.b_nm_per_rad_s * p.ra_ohm + ke_kt;
      c.b0 = k * n / d;
      c.b1 = k * (p.j_kg_m2 * p.ra_ohm + response.lead_s() * n) / d;
      c.b02 = p.series_ohm * p.ke_v_per_rad_s / d;
      break;
    }
    case EstimatedChannel::kIa:
      c.b0 = k * p.b_nm_per_rad_s / d;
      c.b1 = k * (p.j_kg_m2 + response.lead_s() * p.b_nm_per_rad_s) / d;
      c.b02 = -p.ke_v_per_rad_s / d;
      break;
    case EstimatedChannel::kSpeed: {
      const double rpm = ReadingPerOutput(p);
      c.b0 = rpm * k * p.kt_nm_per_a / d;
      c.b1 = rpm * k * response.lead_s() * p.kt_nm_per_a / d;
      c.b02 = rpm * (p.ra_ohm + p.series_ohm) / d;
      break;
    }
  }
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

/// b0 = k q / d, b1 = k (p + lead q) / d, a12 = J R / d, and R = Ra + Rs; what a parameter changes
/// of d, q, p and J R.
struct Terms {
  double d = 0.0;
  double q = 0.0;
  double p = 0.0;
  double jr = 0.0;

  void Add(double factor, const Terms& other) {
    d += factor * other.d;
    q += factor * other.q;
    p += factor * other.p;
    jr += factor * other.jr;
  }
};

/// Of d and J R, which all channels share.
Terms PoleSlopeOf(const PlantParameters& plant, int parameter) {
  const double r = plant.ra_ohm + plant.series_ohm;
  switch (parameter) {
    case kSeries:
    case kRa:
      return {.d = plant.b_nm_per_rad_s, .jr = plant.j_kg_m2};
    case kKe:
      return {.d = plant.kt_nm_per_a};
    case kKt:
      return {.d = plant.ke_v_per_rad_s};
    case kJ:
      return {.jr = r};
    case kB:
      return {.d = r};
    default:
      return {};
  }
}

/// Adds those of q and p, which depend on the channel.
Terms SlopeOf(const PlantParameters& plant, int parameter) {
  Terms slope = PoleSlopeOf(plant, parameter);
  switch (plant.structure->estimated) {
    case EstimatedChannel::kUm:  // q = B Ra + Ke KT, p = J Ra
      if (parameter == kRa) slope.q = plant.b_nm_per_rad_s;
      if (parameter == kRa) slope.p = plant.j_kg_m2;
      if (parameter == kKe) slope.q = plant.kt_nm_per_a;
      if (parameter == kKt) slope.q = plant.ke_v_per_rad_s;
      if (parameter == kJ) slope.p = plant.ra_ohm;
      if (parameter == kB) slope.q = plant.ra_ohm;
      break;
    case EstimatedChannel::kIa:  // q = B, p = J
      if (parameter == kJ) slope.p = 1.0;
      if (parameter == kB) slope.q = 1.0;
      break;
    case EstimatedChannel::kSpeed:  // q = KT in rpm, p = 0
      if (parameter == kKt) slope.q = ReadingPerOutput(plant);
      break;
  }
  return slope;
}

Terms TermsOf(const PlantParameters& plant) {
  const double r = plant.ra_ohm + plant.series_ohm;
  const double ke_kt = plant.ke_v_per_rad_s * plant.kt_nm_per_a;
  const double b = plant.b_nm_per_rad_s;
  Terms t{.d = b * r + ke_kt, .jr = plant.j_kg_m2 * r};
  switch (plant.structure->estimated) {
    case EstimatedChannel::kUm:
      t.q = b * plant.ra_ohm + ke_kt;
      t.p = plant.j_kg_m2 * plant.ra_ohm;
      break;
    case EstimatedChannel::kIa:
      t.q = b;
      t.p = plant.j_kg_m2;
      break;
    case EstimatedChannel::kSpeed:
      t.q = ReadingPerOutput(plant) * plant.kt_nm_per_a;
      break;
  }
  return t;
}

}  // namespace

CoefficientJacobian ContinuousJacobian(const PlantParameters& plant,
                                       std::span<const Component> components) {
  const Terms s = TermsOf(plant);
  const AmplifierResponse response = plant.response();
  const double k = response.gain;
  const double lead = response.lead_s();
  const double b1 = s.p + lead * s.q;  // b1 = k b1 / d
  CoefficientJacobian jacobian(3, static_cast<Eigen::Index>(components.size()));
  Eigen::Index column = 0;
  for (const Component component : components) {
    const ComponentInfo& info = component.info();
    const int parameter = info.parameter;
    if (parameter < kMotorParameters) {
      Terms m = SlopeOf(plant, parameter);
      if (info.coupled >= 0) m.Add(info.coupled_ratio, SlopeOf(plant, info.coupled));
      jacobian.col(column++) << k * (m.q * s.d - s.q * m.d) / (s.d * s.d),
          k * ((m.p + lead * m.q) * s.d - b1 * m.d) / (s.d * s.d),
          (m.jr * s.d - s.jr * m.d) / (s.d * s.d);
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
