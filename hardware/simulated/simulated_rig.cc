#include "hardware/simulated/simulated_rig.h"

#include <cmath>
#include <utility>

#include "core/types/check.h"
#include "hardware/bench/benches.h"
#include "hardware/bench_rig.h"
#include "hardware/paced_rig.h"
#include "hardware/simulated/simulated_daq.h"

namespace faultlab::hardware {
namespace {

/// Both halves of a tick pass on one wake-up: of the period, the longer half of a usual delta.
constexpr double kGrainShare = 0.6;

const core::Bench& BenchOf(const SimulatedRigOptions& options) {
  return options.bench != nullptr ? *options.bench : PaperBench();
}

core::BenchProfile ProfileOf(const SimulatedRigOptions& options) {
  const core::Bench& bench = BenchOf(options);
  if (options.profile.empty()) return bench.profiles.front();
  const core::BenchProfile* profile = bench.FindProfile(options.profile);
  LAB_CHECK(profile != nullptr, options.profile);
  return *profile;
}

core::Quadrants QuadrantsOf(const SimulatedRigOptions& options) {
  return options.amplifier_quadrants.value_or(ProfileOf(options).amplifier.quadrants);
}

std::unique_ptr<RigMachine> MachineOf(const SimulatedRigOptions& options,
                                      std::shared_ptr<const Clock> clock) {
  BenchConfig config = SimulatedBenchConfig(options);
  core::BenchProfile profile = ProfileOf(options);
  profile.amplifier.quadrants = QuadrantsOf(options);
  auto daq = std::make_unique<SimulatedDaq>(
      BenchOf(options), std::move(profile), config.scaling, config.wiring, std::move(clock));
  SimulatorPort* port = daq.get();
  return MakeBenchMachine(std::move(config), std::move(daq), port, nullptr);
}

}  // namespace

BenchConfig SimulatedBenchConfig(const SimulatedRigOptions& options) {
  BenchConfig config = ConfigOf(BenchOf(options));
  RigDescription& description = config.description;
  description.id = options.id;
  description.rig_class = options.rig_class;
  description.kind = options.kind;
  description.any_value = true;
  description.motor_faults = true;
  const core::BenchProfile profile = ProfileOf(options);
  description.delta_s = profile.delta_s;
  description.profile = profile.name;
  description.amplifier_quadrants = QuadrantsOf(options);
  if (options.amplifier_quadrants == core::Quadrants::kFour && config.limits.uc_v_min >= 0.0)
    config.limits.uc_v_min = -config.limits.uc_v_max;
  if (options.gated_speed || profile.converters.counts)
    config.scaling.speed = SpeedMethod::kGatedCount;
  config.timing = {.gap = Nanoseconds(0), .settle = Nanoseconds(0)};  // ideal contacts
  return config;
}

std::unique_ptr<Rig> MakeSimulatedRig(SimulatedRigOptions options) {
  LAB_CHECK(options.speed >= 0.0, options.speed);
  const double speed = options.speed;
  const std::shared_ptr<Clock> clock = MakeSimulatedClock(
      speed, Nanoseconds(std::llround(kGrainShare * BenchOf(options).period_s * 1e9)));
  PacedRigOptions paced{.clock = clock,
                        .wall = MakeSteadyClock(),
                        .queue_messages = options.queue_messages,
                        .wait_for_reader = speed != 1.0,
                        .watchdog = speed > 0.0 ? Nanoseconds(options.watchdog) : Nanoseconds(0)};
  return std::make_unique<PacedRig>(MachineOf(options, clock), std::move(paced));
}

}  // namespace faultlab::hardware
