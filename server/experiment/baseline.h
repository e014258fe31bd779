#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/calibration.h"
#include "server/lab/check_log.h"
#include "server/storage/rig_calibrations.h"

// A baseline is what one run has learnt about a healthy rig, when a later run starts from it. One
// person's measurement becomes everybody's in this way, so it is compared with the rig's norm, with
// the input that it was learnt with, and with the rig's own check.
namespace faultlab::server {

/// How the input of a stretch moves; zeros of an empty one.
InputRange RangeOf(std::span<const double> uc_v);

/// The same of the bench's usual excitation, over `duration_s`.
InputRange UsualRange(const core::Bench& bench, double duration_s);

/// Why this may be nobody's baseline; empty: it may. A guest's never may; others must
/// have moved the input at least half as much as the bench's usual excitation, and each quantity
/// that the data gave must lie within four tolerances of the data sheet.
std::string WhyNoBaseline(const std::string& owner,
                          const InputRange& input,
                          const core::Calibration& calibration,
                          const core::Bench& bench);

/// Whether a run with the input `wanted` stays within what a baseline was learnt with.
bool Covers(const InputRange& learnt, const InputRange& wanted);

/// Whether the newest check between users came after `since`, passed, and found a rig with this
/// calibration: within 5 % (0.06 of a1d) or four standard deviations.
/// @param checks  newest first
bool IsConfirmed(const std::vector<lab::CheckRecord>& checks,
                 WallTime since,
                 const core::Calibration& calibration,
                 const core::Bench& bench,
                 double delta_s);

}  // namespace faultlab::server
