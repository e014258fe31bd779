#pragma once

#include "hardware/clock.h"

namespace faultlab::hardware {

/// Silence of whoever holds a rig, after which the rig ends the run and makes itself safe. A server
/// that holds a far rig keeps it by its words as long as its own reader is not silent for longer:
/// both must count alike, or one of them could keep a motor turning for nobody.
inline constexpr Nanoseconds kHolderSilence = std::chrono::milliseconds(500);

}  // namespace faultlab::hardware
