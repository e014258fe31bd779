#include "core/plant/simulate_record.h"

#include "core/types/check.h"

namespace faultlab::core {

RecordSimulator::RecordSimulator(const BenchProfile& profile,
                                 const PlantParameters& parameters,
                                 std::span<const Fault> faults,
                                 std::uint64_t seed,
                                 double period_s)
    : profile_(profile),
      gear_ratio_(parameters.gear_ratio),
      period_s_(period_s),
      plant_(parameters, profile, StreamSeed(seed, 0)),
      noise_(profile.noise, StreamSeed(seed, 1)),
      counter_(profile.converters.pulses_per_revolution, parameters.gear_ratio),
      schedule_({faults.begin(), faults.end()}, parameters) {
  LAB_CHECK(profile.delta_s > 0.0 && profile.delta_s < period_s, profile.delta_s, period_s);
}

Sample RecordSimulator::Step(double uc_v) {
  Sample sample;
  sample.index = next_++;
  sample.t_s = static_cast<double>(sample.index) * period_s_;
  sample.uc_v = Convert(uc_v, profile_.converters.range_v);
  schedule_.Apply(sample.t_s, plant_);
  plant_.SetInput(sample.uc_v);
  plant_.Advance(profile_.delta_s);
  Acquire(plant_.outputs(), profile_.converters, gear_ratio_, noise_, sample);
  if (profile_.converters.counts) {
    sample.n_rpm = counter_.Rpm(plant_.outputs().angle_rad, period_s_);
  }
  plant_.Advance(period_s_ - profile_.delta_s);
  return sample;
}

std::vector<Sample> SimulateRecord(const BenchProfile& profile,
                                   const PlantParameters& parameters,
                                   std::span<const double> uc_v,
                                   std::span<const Fault> faults,
                                   std::uint64_t seed,
                                   double period_s) {
  RecordSimulator rig(profile, parameters, faults, seed, period_s);
  std::vector<Sample> record;
  record.reserve(uc_v.size());
  for (const double each : uc_v) record.push_back(rig.Step(each));
  return record;
}

}  // namespace faultlab::core
