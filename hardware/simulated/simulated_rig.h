#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "hardware/rig.h"

namespace faultlab::hardware {

struct BenchConfig;

/// A simulated bench, in real time by default.
struct SimulatedRigOptions {
  std::string id = "sim-1";
  std::string rig_class = "bench-sim";
  RigKind kind = RigKind::kSimulated;  ///< kBench: stands in for a real one in a lab
  const core::Bench* bench = nullptr;  ///< what it simulates; null: the paper's
  std::string profile;                 ///< of the bench; empty: its usual one
  /// 1 = real time: a reader that lets the queue fill fails the run, as on a bench.
  /// Other factors are paced by the clock too, but wait for a slow reader.
  /// 0 = as fast as the reader drains.
  double speed = 1.0;
  /// Silence of the holder after which the run ends; real time. Ignored for speed 0. Long, because
  /// nothing burns here: a busy machine on which the reader gets no turn for a second is not a
  /// silent holder.
  std::chrono::milliseconds watchdog{30'000};
  std::size_t queue_messages = 4096;  ///< bound of the queue between the rig and its reader
  std::optional<core::Quadrants> amplifier_quadrants;  ///< none: the profile's
  /// Speed as pulses counted over one period (quantum 1.6 rpm, mean over the period) instead of
  /// the frequency of the last pulses.
  bool gated_speed = false;
};

/// The bench that the options describe: ideal contacts, the profile's delta.
BenchConfig SimulatedBenchConfig(const SimulatedRigOptions& options);

/// A BenchRig whose converters, relay lines and encoder are answered by core's plant. The same
/// plan, seed and commands (at the same samples) give the same samples, whatever the speed.
/// Errors of the options throw core::ContractError.
std::unique_ptr<Rig> MakeSimulatedRig(SimulatedRigOptions options);

}  // namespace faultlab::hardware
