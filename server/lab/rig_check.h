#pragma once

#include <span>
#include <string>

#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::server::lab {

/// The check between users (rule 7): 3 s of the paper's PRBS, then the estimate inside its band.
inline constexpr double kCheckSeconds = 3.0;

struct RigVerdict {
  bool passed = false;
  std::string text;  ///< what failed, for the operator
};

/// Is this record of a check that of a nominal rig? SWA over the newest 200 samples:
///   b0d and gain (b0d+b1d)/(1+a1d) within 10 % of the data sheet's, pole -a1d within 0.12
/// b0d tells every relay position of R1, R9, R12 and C8 from nominal.
/// Too few or invalid samples: no. Pure.
RigVerdict JudgeCheck(std::span<const core::Sample> samples, double period_s, double delta_s);

/// Walks the relays with read-back, plays the PRBS, judges; leaves the rig safe. Blocks as long as
/// the rig's pace needs. Contract: `rig` is idle and leased with `epoch`.
RigVerdict CheckRig(hardware::Rig& rig, hardware::Epoch epoch);

}  // namespace faultlab::server::lab
