#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "hardware/bench_rig.h"
#include "hardware/daq/guarded_daq.h"
#include "hardware/paced_rig.h"
#include "hardware/simulated/simulated_daq.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/faulty_daq.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {

inline constexpr Epoch kEpoch{1};  ///< of a test that needs only one

/// A wall clock that moves only when the test moves it.
class ManualClock final : public Clock {
 public:
  Nanoseconds Now() const override { return Nanoseconds(now_.load()); }
  Wake SleepUntil(Nanoseconds deadline) override {
    if (deadline.count() > now_) now_ = deadline.count();
    return {};
  }
  void Advance(Nanoseconds time) { now_ += time.count(); }

 private:
  std::atomic<std::int64_t> now_{0};
};

/// The simulated clock, but some sleeps end late.
class StumblingClock final : public Clock {
 public:
  /// @param late  lateness of the n-th sleep
  explicit StumblingClock(std::function<Nanoseconds(int)> late) : late_(std::move(late)) {}
  Nanoseconds Now() const override { return Nanoseconds(now_.load()); }
  Wake SleepUntil(Nanoseconds deadline) override {
    const Nanoseconds late = late_(sleeps_++);
    now_ = std::max(deadline.count(), now_.load()) + late.count();
    return {.lateness = late, .wall_lateness = late};
  }

 private:
  const std::function<Nanoseconds(int)> late_;
  std::atomic<std::int64_t> now_{0};
  int sleeps_ = 0;
};

struct TestBenchOptions {
  std::shared_ptr<Clock> clock;  ///< null: simulated, as fast as it is read
  Nanoseconds watchdog{0};
  RigLimits limits = paper::Bench().limits;
  bool wait_for_reader = true;
  std::size_t queue_messages = 64;
  Nanoseconds driver_patience{0};  ///< 0 = the driver is called without a guard
  std::shared_ptr<Heartbeat> heartbeat = nullptr;
};

/// A bench rig (not a simulator: no simulator port, real relay times) whose Daq is the simulated
/// one; all its parts are accessible.
struct TestBench {
  DaqJournal journal;
  SimulatedDaq* daq = nullptr;
  std::shared_ptr<ManualClock> wall = std::make_shared<ManualClock>();
  std::unique_ptr<PacedRig> rig;

  explicit TestBench(TestBenchOptions options = {}) {
    BenchConfig config = SimulatedBenchConfig({});
    config.description.id = "bench-1";
    config.description.kind = RigKind::kBench;
    config.description.any_value = config.description.motor_faults = false;
    config.limits = options.limits;
    config.timing = RelayTiming();
    if (!options.clock) options.clock = MakeSimulatedClock(0.0, Nanoseconds(0));
    auto simulated = std::make_unique<SimulatedDaq>(
        paper::Bench(), paper::Hardware(), config.scaling, config.wiring, options.clock);
    daq = simulated.get();
    daq->BeginRun(1);
    std::unique_ptr<Daq> driver = std::make_unique<FaultyDaq>(std::move(simulated), journal);
    if (options.driver_patience.count() > 0) {
      driver = MakeGuardedDaq(std::move(driver), {.patience = options.driver_patience});
    }
    rig = std::make_unique<PacedRig>(MakeBenchMachine(config, std::move(driver), nullptr, wall),
                                     PacedRigOptions{.clock = options.clock,
                                                     .wall = wall,
                                                     .queue_messages = options.queue_messages,
                                                     .wait_for_reader = options.wait_for_reader,
                                                     .watchdog = options.watchdog,
                                                     .heartbeat = options.heartbeat});
  }

  bool IsSafe() const {
    const std::uint32_t nominal = ~((1u << 17) | (1u << 19) | (1u << 21) | (1u << 6));
    return daq->drive_v() == 0.0 && daq_levels() == nominal;
  }
  std::uint32_t daq_levels() const { return const_cast<SimulatedDaq*>(daq)->ReadRelayLines(); }
};

}  // namespace faultlab::hardware
