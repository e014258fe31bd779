#pragma once

// Motors as they are: a simulator that shares no code with the product's (Runge-Kutta steps, its
// own friction, noise and supply), with the physics that the product's model does not have.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/types/sample.h"

namespace faultlab::core {

inline constexpr double kFrictionTauS = 0.5;

// What real motors do and the model of the product does not know. All 0: none of it.
struct Physics {
  double brush_v = 0.0;              // drop of the brushes, whatever the current
  double brush_ohm = 0.0;            // resistance of the brushes, ..
  double brush_a = 0.5;              // .. half of it at this current
  double brush_s_ohm_per_rad = 0.0;  // resistance that grows with the speed
  double sag_a = 0.0;                // above this current the amplifier gives way, ..
  double sag_ohm = 0.0;              // .. by so much
  double fan = 0.0;                  // torque of air, Nm/(rad/s)^2
  double stribeck_nm = 0.0;          // friction that vanishes with the speed, ..
  double stribeck_rad_s = 10.0;      // .. by here
  double ripple = 0.0;               // share of Ke, six times a revolution
  double cogging_nm = 0.0;           // twelve times a revolution
  double tachometer_ripple = 0.0;    // share of n, once a revolution
  double n_zero_rpm = 0.0;
  double ia_zero_a = 0.0;
  double warming_per_s = 0.0;  // Ra rises by this share; ..
  double magnet = 0.5;         // .. Ke falls by so much of it
};

// A rig as it is, not as its data sheet says.
struct Rig {
  double period_s, delta_s;
  double k, rs, ra, la, ke, kt, j, b, mc;
  double supply_min_v, supply_max_v;
  double low_v, high_v;
  int clock;  // periods of one step of the input
  double ia_noise, ia_max, n_noise;
  bool has_um;
  double speed_step_s = 0.0;  // 1/speed is read in multiples of it: an encoder and its timer
  double friction_noise_nm = 0.0;
  double breakaway_nm = 0.0;  // what friction holds at rest, where it is more than Mc
  double still_rad_s = 0.0;   // a slower motor is read as standing
  double pulse_rad = 0.0;     // the speed is read as it was one pulse ago
  double gear = 1.0;          // n is the speed behind it
  Physics physics = {};
};

class Motor {
 public:
  explicit Motor(const Rig& of) : rig(of) {}

  double output_v(double uc_v) const {
    const Physics& p = rig.physics;
    const double gives_way = p.sag_ohm * std::max(0.0, std::abs(i) - p.sag_a);
    return std::clamp(
        rig.k * uc_v - std::copysign(gives_way, i), rig.supply_min_v, rig.supply_max_v);
  }

  void Run(double uc_v, double duration_s) {
    const double step_max_s =
        std::min({1e-4, rig.period_s / 20.0, 0.5 * rig.la / (rig.ra + rig.rs)});
    const int steps = static_cast<int>(std::ceil(duration_s / step_max_s));
    const double h = duration_s / steps;
    const Physics& p = rig.physics;
    for (int n = 0; n < steps; ++n) {
      const double held = std::max(rig.mc, rig.breakaway_nm) + drag_nm;
      const double warmth = 1.0 + p.warming_per_s * t_s;
      const double magnet =
          (1.0 - p.magnet * p.warming_per_s * t_s) * (1.0 + p.ripple * std::cos(6.0 * angle));
      const double cogging = p.cogging_nm * std::sin(12.0 * angle);
      const bool stands = std::abs(w) < 0.05 && std::abs(rig.kt * i) <= held;
      if (stands) w = 0.0;
      const double way = w != 0.0 ? std::copysign(1.0, w) : std::copysign(1.0, i);
      const auto slope = [&](double current, double speed, double& di, double& dw) {
        const double brushes = p.brush_v * std::tanh(current / 0.02) +
                               current * (p.brush_ohm / (1.0 + std::abs(current) / p.brush_a) +
                                          p.brush_s_ohm_per_rad * std::abs(speed));
        const double slow_nm = p.stribeck_nm * std::exp(-std::abs(speed) / p.stribeck_rad_s);
        const double friction =
            (rig.mc + drag_nm + slow_nm) * way + p.fan * speed * std::abs(speed) + cogging;
        di = (output_v(uc_v) - (rig.ra * warmth + rig.rs) * current - brushes -
              magnet * rig.ke * speed) /
             rig.la;
        dw = stands ? 0.0 : (magnet * rig.kt * current - rig.b * speed - friction) / rig.j;
      };
      double i1, w1, i2, w2, i3, w3, i4, w4;
      slope(i, w, i1, w1);
      slope(i + 0.5 * h * i1, w + 0.5 * h * w1, i2, w2);
      slope(i + 0.5 * h * i2, w + 0.5 * h * w2, i3, w3);
      slope(i + h * i3, w + h * w3, i4, w4);
      const double before = w;
      i += h / 6.0 * (i1 + 2.0 * i2 + 2.0 * i3 + i4);
      w += h / 6.0 * (w1 + 2.0 * w2 + 2.0 * w3 + w4);
      acceleration = (w - before) / h;
      if (before * w < 0.0) w = 0.0;
      angle += h * w;
      t_s += h;
    }
  }

  Rig rig;
  double i = 0.0;
  double w = 0.0;
  double angle = 0.0;
  double t_s = 0.0;
  double acceleration = 0.0;
  double drag_nm = 0.0;  // in addition to Mc
};

inline double SpeedAPulseAgo(const Motor& motor, double period_s) {
  if (motor.rig.pulse_rad == 0.0 || motor.w == 0.0) return motor.w;
  const double ago_s = std::min(motor.rig.pulse_rad / std::abs(motor.w), period_s);
  return motor.w - motor.acceleration * ago_s;
}

inline double Rounded(double w, double step_s) {
  return step_s > 0.0 && w != 0.0 ? 1.0 / (std::round(1.0 / (w * step_s)) * step_s) : w;
}

// `levels` >= 2: of the input, between low_v and high_v. `faulty` from `from_s` on.
inline std::vector<Sample> RecordFor(const Rig& rig,
                                     const Rig& faulty,
                                     double from_s,
                                     double duration_s,
                                     unsigned seed,
                                     int levels = 2) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::bernoulli_distribution coin;
  std::uniform_int_distribution<int> level(0, levels - 1);
  Motor motor(rig);
  std::vector<Sample> record;
  double uc = rig.low_v;
  const auto samples = static_cast<int>(std::lround(duration_s / rig.period_s));
  for (int k = 0; k < samples; ++k) {
    const double t_s = k * rig.period_s;
    if (t_s >= from_s - 1e-9) motor.rig = faulty;
    if (k % rig.clock == 0) {
      const double share = levels == 2 ? coin(random) : level(random) / (levels - 1.0);
      uc = motor.rig.low_v + (motor.rig.high_v - motor.rig.low_v) * share;
    }
    if (rig.friction_noise_nm > 0.0) {
      const double kept = std::exp(-rig.period_s / kFrictionTauS);
      motor.drag_nm = kept * motor.drag_nm +
                      std::sqrt(1.0 - kept * kept) * rig.friction_noise_nm * normal(random);
    }
    motor.Run(uc, rig.delta_s);
    Sample sample;
    sample.index = k;
    sample.t_s = t_s;
    sample.uc_v = uc;
    if (rig.has_um) {
      sample.um_v = motor.output_v(uc) - motor.rig.rs * motor.i + 0.01 * normal(random);
    }
    const Physics& p = rig.physics;
    sample.ia_a =
        std::clamp(motor.i + p.ia_zero_a + rig.ia_noise * normal(random), -rig.ia_max, rig.ia_max);
    const double w = SpeedAPulseAgo(motor, rig.period_s);
    sample.n_rpm = Rounded(std::abs(w) < rig.still_rad_s ? 0.0 : w, rig.speed_step_s) * 30.0 /
                       std::numbers::pi / rig.gear *
                       (1.0 + p.tachometer_ripple * std::cos(motor.angle / rig.gear)) +
                   p.n_zero_rpm + rig.n_noise * normal(random);
    record.push_back(sample);
    motor.Run(uc, rig.period_s - rig.delta_s);
  }
  return record;
}

}  // namespace faultlab::core
