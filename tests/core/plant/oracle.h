#pragma once

#include <array>
#include <cmath>

#include "core/bench/profile.h"
#include "core/types/plant_parameters.h"
#include "tests/paper_bench.h"

namespace faultlab::core {

/// An independent integration of paper Eq. (1)-(2) for tests: classical Runge-Kutta of fourth order
/// with a step far below every time constant; friction is evaluated at every step. Shares no code
/// with Plant: no matrix exponential, no event search.
class RungeKuttaPlant {
 public:
  RungeKuttaPlant(const PlantParameters& p, const FrictionModel& friction) : p_(p), f_(friction) {}

  using State = std::array<double, 3>;  // vC8, i, w

  void Advance(double seconds, double uc_v, double step_s) {
    const int steps = static_cast<int>(std::round(seconds / step_s));
    for (int n = 0; n < steps; ++n) {
      if (sense_ == 0 && std::abs(p_.kt_nm_per_a * x_[1]) > f_.ms_nm) {
        sense_ = x_[1] > 0.0 ? 1 : -1;
      }
      const State k1 = Slope(x_, uc_v);
      const State k2 = Slope(Add(x_, k1, 0.5 * step_s), uc_v);
      const State k3 = Slope(Add(x_, k2, 0.5 * step_s), uc_v);
      const State k4 = Slope(Add(x_, k3, step_s), uc_v);
      for (std::size_t j = 0; j < 3; ++j) {
        x_[j] += step_s / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
      }
      if (sense_ * x_[2] < 0.0) {
        x_[2] = 0.0;
        sense_ = 0;
      }
    }
  }

  double Output(double uc_v) const { return OutputOf(x_, uc_v) - p_.series_ohm * x_[1]; }
  const State& state() const { return x_; }

 private:
  double OutputOf(const State& x, double uc_v) const {
    const auto of = [&](const char* symbol) { return paper::Value(p_, symbol); };
    const double re1_ohm = of("R9") * of("R10") / (of("R9") + of("R10"));
    const double re2_ohm = of("R12") + of("R14") + of("R15");
    const double g = 1.0 / of("R5") + 1.0 / re2_ohm;
    return (uc_v / re1_ohm + x[0] / of("R5")) / g;
  }

  State Slope(const State& x, double uc_v) const {
    const double out = OutputOf(x, uc_v);
    const double speed = std::abs(x[2]) / f_.stribeck_speed_rad_s;
    const double more =
        f_.stribeck_shape == 0 ? 0.0 : std::exp(-std::pow(speed, f_.stribeck_shape));
    const double torque = f_.mc_nm + (f_.ms_nm - f_.mc_nm) * more;
    State slope;
    slope[0] = (out - x[0]) / (paper::Value(p_, "R5") * p_.Get(paper::kC8));
    slope[1] = (out - (p_.ra_ohm + p_.series_ohm) * x[1] - p_.ke_v_per_rad_s * x[2]) / p_.la_henry;
    slope[2] = sense_ == 0 ? 0.0
                           : (p_.kt_nm_per_a * x[1] - p_.b_nm_per_rad_s * x[2] - sense_ * torque) /
                                 p_.j_kg_m2;
    return slope;
  }

  static State Add(const State& x, const State& slope, double step) {
    return {x[0] + step * slope[0], x[1] + step * slope[1], x[2] + step * slope[2]};
  }

  PlantParameters p_ = paper::Plant();
  FrictionModel f_;
  State x_{};
  int sense_ = 0;
};

}  // namespace faultlab::core
