#pragma once

#include <functional>

#include "hardware/relay_board.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// Walks the positions of all relay boards, one after the other.
/// @param connect  makes the rig safe, then connects the position and reads it back; an IoError is
///                 the text of a position that does not answer
SelfTestReport WalkPositions(
    const RelayWiring& wiring,
    const RelayBoard& relays,
    const std::function<void(core::Component component, int position)>& connect);

}  // namespace faultlab::hardware
