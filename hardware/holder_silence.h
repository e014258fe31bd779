#pragma once

#include "hardware/clock.h"

namespace faultlab::hardware {

/// Silence of whoever holds a rig, after which the rig ends the run and makes itself safe. The
/// server that holds a far rig stops speaking for its own reader after the same time, so that the
/// rig stops within twice this time when the reader has gone.
inline constexpr Nanoseconds kHolderSilence = std::chrono::milliseconds(500);

}  // namespace faultlab::hardware
