#pragma once

#include <memory>
#include <utility>

#include "hardware/device/device_machine.h"
#include "hardware/paced_rig.h"
#include "tests/device/simulated_device.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {

/// The paper's bench as a rig file of the simulated device would say it.
inline BenchConfig DeviceBenchConfig() {
  BenchConfig config = ConfigOf(paper::Bench());
  config.description.id = "device-1";
  config.description.kind = RigKind::kBench;
  config.scaling = BenchAtPins::Scaling();
  config.wiring.inverted = false;
  return config;
}

/// A rig in lockstep with its device.
inline std::unique_ptr<PacedRig> MakeLockstepRig(SimulatedDevice& device,
                                                 BenchConfig config = DeviceBenchConfig()) {
  const std::shared_ptr<Clock> clock = device.clock();
  PacedRigOptions options{.clock = clock, .wall = clock};
  options.wait_for_reader = true;
  options.queue_messages = 4;  // the device does not run ahead of the test
  options.watchdog = Nanoseconds(0);
  return std::make_unique<PacedRig>(
      MakeDeviceMachine(
          std::move(config), {.port = device.port()}, clock, {.connect = std::chrono::seconds(1)}),
      std::move(options));
}

}  // namespace faultlab::hardware
