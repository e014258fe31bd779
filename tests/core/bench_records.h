#pragma once

#include <cmath>
#include <vector>

#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "core/types/fault.h"
#include "tests/paper_bench.h"

namespace faultlab::core {

inline Fault AbruptFault(Component component, double value, double at_s = 10.0) {
  Fault fault;
  fault.component = component;
  fault.value = value;
  fault.at_s = at_s;
  return fault;
}

/// A run of the simulated bench under the paper's excitation.
inline std::vector<Sample> BenchRecord(const std::vector<Fault>& faults,
                                       std::uint64_t seed = 1,
                                       double duration_s = 20.0,
                                       const PlantParameters& rig = paper::Plant(),
                                       double clock_s = 0.01) {
  PrbsSpec spec;
  spec.seed = seed;
  spec.clock_s = clock_s;
  const auto samples = static_cast<int>(std::lround(duration_s / paper::kPeriodS));
  const std::vector<double> uc = MakePrbs(spec, samples, paper::kPeriodS);
  return SimulateRecord(paper::Hardware(), rig, uc, faults, seed, paper::kPeriodS);
}

/// The samples of [from_s, to_s).
inline std::vector<Sample> Between(const std::vector<Sample>& record, double from_s, double to_s) {
  std::vector<Sample> part;
  for (const Sample& sample : record) {
    if (sample.t_s >= from_s && sample.t_s < to_s) part.push_back(sample);
  }
  return part;
}

}  // namespace faultlab::core
