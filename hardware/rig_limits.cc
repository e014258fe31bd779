#include "hardware/rig_limits.h"

#include <algorithm>
#include <cmath>

#include "hardware/refusal.h"

namespace faultlab::hardware {
namespace {

/// Rounding of a step that is exactly the limit.
constexpr double kRounding = 1e-9;

Trip MakeTrip(const char* name,
              double value,
              double limit,
              const core::Sample& sample,
              const char* what,
              const char* unit) {
  return {.name = name,
          .value = value,
          .limit = limit,
          .index = sample.index,
          .t_s = sample.t_s,
          .text = std::string(what) + " " + Number(value) + " " + unit + ", allowed " +
                  Number(limit) + " " + unit};
}

}  // namespace

core::Status CheckExcitation(const RunPlan& plan, const RigLimits& limits) {
  if (!(plan.period_s >= 1e-3 && plan.period_s <= 1.0)) {
    return core::Refuse("number_outside",
                        "period_s",
                        {{"member", "period_s"}, {"lowest", 0.001}, {"highest", 1.0}});
  }
  if (plan.uc_v.empty()) return core::Refuse("voltages_wrong", "uc_v");
  const double step_max = limits.slew_v_per_s * plan.period_s * (1.0 + kRounding);
  double before = 0.0;
  for (std::size_t k = 0; k < plan.uc_v.size(); ++k) {
    const double uc_v = plan.uc_v[k];
    if (!(uc_v >= limits.uc_v_min && uc_v <= limits.uc_v_max)) {
      return core::Refuse("voltage_too_high",
                          "uc_v/" + std::to_string(k),
                          {{"value_v", Number(uc_v)},
                           {"lowest_v", Number(limits.uc_v_min)},
                           {"highest_v", Number(limits.uc_v_max)}});
    }
    if (std::abs(uc_v - before) > step_max) {
      return core::Refuse("voltage_steps",
                          "uc_v/" + std::to_string(k),
                          {{"step_v", Number(uc_v - before)}, {"most_v", Number(step_max)}});
    }
    before = uc_v;
  }
  return core::Done{};
}

void Interlocks::Rest(double seconds) {
  heat_a2_ *= std::exp(-std::max(seconds, 0.0) / limits_.thermal_tau_s);
}

std::optional<Trip> Interlocks::Check(const core::Sample& sample, double dt_s) {
  const double voltage_v = std::max(std::isnan(sample.um_v) ? 0.0 : std::abs(sample.um_v),
                                    std::isnan(sample.ua_v) ? 0.0 : std::abs(sample.ua_v));
  const double current_a = std::isnan(sample.ia_a) ? 0.0 : std::abs(sample.ia_a);

  const double keep = std::exp(-dt_s / limits_.thermal_tau_s);
  heat_a2_ = heat_a2_ * keep + current_a * current_a * (1.0 - keep);
  const bool stalled = current_a > limits_.stall_current_a && !std::isnan(sample.n_rpm) &&
                       std::abs(sample.n_rpm) < limits_.stall_speed_rpm;
  stalled_s_ = stalled ? stalled_s_ + dt_s : 0.0;

  if (voltage_v > limits_.voltage_v_max) {
    return MakeTrip("over_voltage", voltage_v, limits_.voltage_v_max, sample, "motor voltage", "V");
  }
  if (current_a > limits_.current_peak_a) {
    return MakeTrip(
        "over_current", current_a, limits_.current_peak_a, sample, "motor current", "A");
  }
  if (heat_a2_ > limits_.current_continuous_a * limits_.current_continuous_a) {
    return MakeTrip("over_heat",
                    std::sqrt(heat_a2_),
                    limits_.current_continuous_a,
                    sample,
                    "thermal mean of the current",
                    "A");
  }
  if (stalled_s_ > limits_.stall_s) {
    return MakeTrip(
        "stall", stalled_s_, limits_.stall_s, sample, "motor stands under current for", "s");
  }
  return std::nullopt;
}

}  // namespace faultlab::hardware
