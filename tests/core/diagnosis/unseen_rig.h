#pragma once

// For benches that are not among the shipped ones, described in a few lines each: a simulator that
// shares no code with the product's (Runge-Kutta steps, its own friction, noise and supply), and
// what their diagnoses are asked.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "hardware/bench/benches.h"
#include "tests/core/diagnosis/verdicts.h"

namespace faultlab::core {

inline constexpr double kHealthyS = 8.0;
inline constexpr double kDurationS = 14.0;
inline constexpr double kFrictionTauS = 0.5;

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
};

class Motor {
 public:
  explicit Motor(const Rig& of) : rig(of) {}

  double output_v(double uc_v) const {
    return std::clamp(rig.k * uc_v, rig.supply_min_v, rig.supply_max_v);
  }

  void Run(double uc_v, double duration_s) {
    const double step_max_s =
        std::min({1e-4, rig.period_s / 20.0, 0.5 * rig.la / (rig.ra + rig.rs)});
    const int steps = static_cast<int>(std::ceil(duration_s / step_max_s));
    const double h = duration_s / steps;
    for (int n = 0; n < steps; ++n) {
      const double held = std::max(rig.mc, rig.breakaway_nm) + drag_nm;
      const bool stands = std::abs(w) < 0.05 && std::abs(rig.kt * i) <= held;
      if (stands) w = 0.0;
      const double way = w != 0.0 ? std::copysign(1.0, w) : std::copysign(1.0, i);
      const auto slope = [&](double current, double speed, double& di, double& dw) {
        di = (output_v(uc_v) - (rig.ra + rig.rs) * current - rig.ke * speed) / rig.la;
        dw = stands ? 0.0 : (rig.kt * current - rig.b * speed - (rig.mc + drag_nm) * way) / rig.j;
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
    }
  }

  Rig rig;
  double i = 0.0;
  double w = 0.0;
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

// `faulty` from kHealthyS on.
inline std::vector<Sample> Record(const Rig& rig, const Rig& faulty, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::bernoulli_distribution coin;
  Motor motor(rig);
  std::vector<Sample> record;
  double uc = rig.low_v;
  const auto samples = static_cast<int>(std::lround(kDurationS / rig.period_s));
  for (int k = 0; k < samples; ++k) {
    const double t_s = k * rig.period_s;
    if (t_s >= kHealthyS - 1e-9) motor.rig = faulty;
    if (k % rig.clock == 0) uc = coin(random) ? rig.high_v : rig.low_v;
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
    sample.ia_a = std::clamp(motor.i + rig.ia_noise * normal(random), -rig.ia_max, rig.ia_max);
    const double w = SpeedAPulseAgo(motor, rig.period_s);
    sample.n_rpm = Rounded(std::abs(w) < rig.still_rad_s ? 0.0 : w, rig.speed_step_s) * 30.0 /
                       std::numbers::pi +
                   rig.n_noise * normal(random);
    record.push_back(sample);
    motor.Run(uc, rig.period_s - rig.delta_s);
  }
  return record;
}

inline const Bench& BenchOf(const std::string& text) {
  const Result<const Bench*> bench = hardware::KeepBench(text, "unseen.toml");
  if (!bench.ok()) throw std::runtime_error(bench.error().message);
  return *bench.value();
}

inline Diagnosis Diagnose(const Bench& bench, const std::vector<Sample>& record) {
  DiagnosisOptions options = OptionsOf(bench);
  options.healthy_to_s = kHealthyS - 0.5;
  return DiagnoseRecord(record, options);
}

inline void ExpectNamed(const Bench& bench,
                        const std::vector<Sample>& record,
                        const char* symbol,
                        double value,
                        double allowed) {
  const Diagnosis diagnosis = Diagnose(bench, record);
  ASSERT_FALSE(diagnosis.calibration_refusal.has_value()) << diagnosis.calibration_refusal->message;
  const Verdict& verdict = diagnosis.verdict;
  const Component component = bench.Find(symbol).value();
  ASSERT_EQ(verdict.kind, VerdictKind::kFault) << symbol << ' ' << value << ": " << verdict.reason;
  ASSERT_EQ(verdict.group, std::vector<Component>{component}) << verdict.reason;
  EXPECT_NEAR(ValueOf(verdict, component), value, allowed * value) << verdict.reason;
  EXPECT_GE(*verdict.detected_at_s, kHealthyS - 1e-9);
}

}  // namespace faultlab::core
