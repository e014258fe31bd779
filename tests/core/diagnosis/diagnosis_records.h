#pragma once

#include <cmath>
#include <vector>

#include "core/diagnosis/diagnosis.h"
#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"

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
                                       const PlantParameters& rig = {},
                                       double clock_s = 0.01) {
  PrbsSpec spec;
  spec.seed = seed;
  spec.clock_s = clock_s;
  const auto samples = static_cast<int>(std::lround(duration_s / kSamplePeriodSeconds));
  const std::vector<double> uc = MakePrbs(spec, samples, kSamplePeriodSeconds);
  return SimulateRecord(BenchProfileBench(), rig, uc, faults, seed);
}

inline DiagnosisOptions FreeValues(Channels channels) {
  DiagnosisOptions options;
  options.channels = channels;
  options.values = ValuePrior::kNone;
  return options;
}

inline bool Names(const Verdict& verdict, Component component) {
  for (Component named : verdict.group) {
    if (named == component) return true;
  }
  return false;
}

inline double ValueOf(const Verdict& verdict, Component component) {
  for (const Candidate& candidate : verdict.candidates) {
    if (candidate.component == component) return candidate.value;
  }
  return std::nan("");
}

}  // namespace faultlab::core
