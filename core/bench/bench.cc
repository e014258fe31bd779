#include "core/bench/bench.h"

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

}  // namespace faultlab::core
