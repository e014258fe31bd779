#include "core/bench/bench.h"

#include <algorithm>
#include <numbers>

namespace faultlab::core {
namespace {

// The speed from the last pulses is that of a moment ago, which is another one where the motor has
// just passed through rest. It is known well enough from so many pulses in a period on, ..
constexpr double kTimedPulses = 200.0;
// .. or, of an encoder that is too coarse for that, above this share of the usual speed.
constexpr double kSlowShare = 0.3;
// A mean whose middle is the edge itself is taken to be of a moment beside it.
constexpr double kEdgeShare = 0.02;

}  // namespace

std::vector<Component> Bench::components() const {
  std::vector<Component> out;
  for (const ComponentInfo& part : parts) out.emplace_back(part);
  return out;
}

std::optional<Component> Bench::Find(std::string_view symbol) const {
  for (const ComponentInfo& part : parts) {
    if (part.symbol == symbol) return Component(part);
  }
  return std::nullopt;
}

const BenchProfile* Bench::FindProfile(std::string_view profile) const {
  for (const BenchProfile& each : profiles) {
    if (each.name == profile) return &each;
  }
  return nullptr;
}

bool Bench::reads_means() const {
  return n.counted && structure->estimated == EstimatedChannel::kSpeed;
}

double Bench::ReadingDelay(double sampled_s, double period) const {
  if (!reads_means()) return sampled_s;
  const double middle_s = sampled_s + (follows_row_before() ? 0.5 : -0.5) * period;
  return std::clamp(middle_s, kEdgeShare * period, (1.0 - kEdgeShare) * period);
}

ReadingRules Bench::readings() const {
  const double ohm = nominal.ra_ohm + nominal.series_ohm;
  const double torque_per_speed =
      nominal.b_nm_per_rad_s * ohm + nominal.ke_v_per_rad_s * nominal.kt_nm_per_a;
  return {.has_um = um.exists,
          .has_ia = ia.exists,
          .has_n = estimates_use_n(),
          .of_row_before = follows_row_before(),
          .ia = ia.Inside(),
          .speed_floor_rad_s = SpeedFloor(),
          .speed_per_v = nominal.gain() * nominal.kt_nm_per_a / torque_per_speed,
          .speed_friction_rad_s = norm.mc_nm * ohm / torque_per_speed,
          .speed_time_constant_s = nominal.j_kg_m2 * ohm / torque_per_speed,
          .gear_ratio = nominal.gear_ratio};
}

double Bench::SpeedFloor() const {
  if (!reverses() || n.step_s <= 0.0) return 0.0;
  const double per_pulse = 2.0 * std::numbers::pi / pulses_per_revolution;
  const double timed =
      std::min(kTimedPulses * per_pulse / period_s, kSlowShare * usual_speed_rad_s);
  return std::max(per_pulse / kPulseTimeoutS, timed);
}

}  // namespace faultlab::core
