#pragma once

#include <string_view>

#include "core/bench/bench.h"
#include "core/types/result.h"

namespace faultlab::server {

/// "um" (the voltage alone) or "all". Refuses (kInvalid, field "channels") other words, and um on
/// a bench that does not measure it.
core::Result<core::Channels> ParseChannels(std::string_view text, const core::Bench& bench);

}  // namespace faultlab::server
