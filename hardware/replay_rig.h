#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

struct ReplayRigOptions {
  const core::Bench* bench = nullptr;  ///< what was recorded; never null
  std::string id = "replay";
  double speed = 1.0;  ///< as SimulatedRigOptions::speed
  std::chrono::milliseconds watchdog{30'000};
  std::size_t queue_messages = 4096;
  /// Events of the recording to play beside its samples, in order of their index.
  std::vector<RigEvent> events;
};

/// A recording plays as if it ran: the samples come out bit-equal, paced by the plan's period.
/// The plan of Arm gives the period only; its uc_v and faults must be empty (the recording has its
/// own), ReplayPlan() makes one. Commands are refused: the past cannot be changed.
/// An empty recording throws core::ContractError.
std::unique_ptr<Rig> MakeReplayRig(std::vector<core::Sample> samples, ReplayRigOptions options);

/// The plan with which a recording is replayed.
RunPlan ReplayPlan(double period_s);

}  // namespace faultlab::hardware
