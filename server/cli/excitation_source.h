#pragma once

#include <cstdint>
#include <string>

#include "core/signals/excitation.h"
#include "core/types/result.h"

namespace faultlab::server {

/// What ParseExcitation reads, or "file:RECORDING.csv": its uc_v, as long as it is.
core::Result<core::ExcitationSpec> ReadExcitation(const std::string& text, std::uint64_t seed);

}  // namespace faultlab::server
