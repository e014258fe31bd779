#include "core/plant/simulate_record.h"

#include "core/plant/converters.h"
#include "core/plant/fault_schedule.h"
#include "core/plant/plant.h"
#include "core/types/check.h"

namespace faultlab::core {

std::vector<Sample> SimulateRecord(const BenchProfile& profile,
                                   const PlantParameters& parameters,
                                   std::span<const double> uc_v,
                                   std::span<const Fault> faults,
                                   std::uint64_t seed,
                                   double period_s) {
  LAB_CHECK(profile.delta_s > 0.0 && profile.delta_s < period_s, profile.delta_s, period_s);
  Plant plant(parameters, profile, StreamSeed(seed, 0));
  MeasurementNoise noise(profile.noise, StreamSeed(seed, 1));
  PulseCounter counter(profile.converters.pulses_per_revolution, parameters.gear_ratio);
  FaultSchedule schedule({faults.begin(), faults.end()}, parameters);

  std::vector<Sample> record(uc_v.size());
  for (std::size_t k = 0; k < uc_v.size(); ++k) {
    Sample& sample = record[k];
    sample.index = static_cast<std::int64_t>(k);
    sample.t_s = static_cast<double>(k) * period_s;
    sample.uc_v = Convert(uc_v[k], profile.converters.range_v);
    schedule.Apply(sample.t_s, plant);
    plant.SetInput(sample.uc_v);
    plant.Advance(profile.delta_s);
    Acquire(plant.outputs(), profile.converters, parameters.gear_ratio, noise, sample);
    if (profile.converters.counts) {
      sample.n_rpm = counter.Rpm(plant.outputs().angle_rad, period_s);
    }
    plant.Advance(period_s - profile.delta_s);
  }
  return record;
}

}  // namespace faultlab::core
