#include "core/bench/bench.h"

#include <numbers>

namespace faultlab::core {

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

ReadingRules Bench::readings() const {
  return {.has_um = um.exists,
          .has_ia = ia.exists,
          .has_n = n.exists,
          .ia = ia.Inside(),
          .speed_floor_rad_s = SpeedFloor(),
          .gear_ratio = nominal.gear_ratio};
}

double Bench::SpeedFloor() const {
  if (!reverses() || n.step_s <= 0.0) return 0.0;
  return 2.0 * std::numbers::pi / (pulses_per_revolution * kPulseTimeoutS);
}

}  // namespace faultlab::core
