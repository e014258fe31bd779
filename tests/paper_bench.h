#pragma once

#include <vector>

#include "core/bench/bench.h"
#include "core/types/check.h"
#include "hardware/bench/benches.h"

/// The shipped paper's bench, for tests that check its numbers.
namespace faultlab::paper {

inline const core::Bench& Bench() {
  return hardware::PaperBench();
}

inline core::Component Part(const char* symbol) {
  const auto found = Bench().Find(symbol);
  LAB_CHECK(found.has_value(), symbol);
  return *found;
}

inline const core::Component kR1 = Part("R1");
inline const core::Component kR9 = Part("R9");
inline const core::Component kR12 = Part("R12");
inline const core::Component kC8 = Part("C8");
inline const core::Component kRa = Part("Ra");
inline const core::Component kJ = Part("J");
inline const core::Component kB = Part("B");

inline constexpr double kPeriodS = 0.01;
inline constexpr double kGearRatio = 3.8;

inline const std::vector<core::Component>& Parts() {
  static const std::vector<core::Component> parts = Bench().components();
  return parts;
}

/// The values that relays connect, nominal first.
inline std::vector<double> RelayValues(core::Component component) {
  std::vector<double> values;
  for (const auto& position : component.info().positions) values.push_back(position.value);
  return values;
}

/// A parameter by its symbol, including those that no fault changes.
inline double Value(const core::PlantParameters& plant, const char* symbol) {
  return plant.Get(plant.structure->Find(symbol));
}

/// The data sheet.
inline const core::PlantParameters& Plant() {
  return Bench().nominal;
}

/// Its two simulators.
inline const core::BenchProfile& Hardware() {
  return *Bench().FindProfile("bench");
}
inline const core::BenchProfile& CircuitSimulation() {
  return *Bench().FindProfile("multisim");
}

}  // namespace faultlab::paper
