#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/bench/profile.h"
#include "core/plant/converters.h"
#include "core/plant/fault_schedule.h"
#include "core/plant/plant.h"
#include "core/types/fault.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// A simulated rig, as its converters read it, one sample after another. At t_k = k T faults act
/// and uc(k) is written (through the 16-bit converter); at t_k + delta um(k), ua(k), ia(k), n(k)
/// are read. The plant starts at rest. The same arguments give the same bits. Contract: 0 < delta <
/// period, finite uc.
class RecordSimulator {
 public:
  /// `profile` must outlive it.
  RecordSimulator(const BenchProfile& profile,
                  const PlantParameters& parameters,
                  std::span<const Fault> faults,
                  std::uint64_t seed,
                  double period_s);

  Sample Step(double uc_v);
  /// True, of the motor shaft, at the end of the newest period.
  double speed_rad_s() const { return plant_.outputs().omega_rad_s; }

 private:
  const BenchProfile& profile_;
  double gear_ratio_;
  double period_s_;
  Plant plant_;
  MeasurementNoise noise_;
  PulseCounter counter_;
  FaultSchedule schedule_;
  std::int64_t next_ = 0;
};

/// A whole run of it.
std::vector<Sample> SimulateRecord(const BenchProfile& profile,
                                   const PlantParameters& parameters,
                                   std::span<const double> uc_v,
                                   std::span<const Fault> faults,
                                   std::uint64_t seed,
                                   double period_s);

}  // namespace faultlab::core
