#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/types/frame.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// Recomputes the estimates of a recording, through the same pipeline as the live run: bit-equal to
/// what was streamed. `each` is called once per sample, in order.
void ReplayFrames(std::span<const core::Sample> samples,
                  double period_s,
                  const std::function<void(const core::Frame&)>& each);

}  // namespace faultlab::server
