#pragma once

#include <cstdint>
#include <string>

#include "core/signals/excitation.h"
#include "core/types/result.h"

namespace faultlab::server {

/// Accepts what ParseExcitation accepts, and "file:RECORDING.csv": the recording's whole uc_v.
core::Result<core::ExcitationSpec> ReadExcitation(const std::string& text, std::uint64_t seed);

}  // namespace faultlab::server
