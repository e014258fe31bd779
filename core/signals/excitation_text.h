#pragma once

#include <cstdint>
#include <string_view>

#include "core/signals/excitation.h"
#include "core/types/result.h"

namespace faultlab::core {

/// "prbs", "prbs:low=2,high=3,clock=0.01,order=10,seed=1", "step:low=2,high=3,at=1",
/// "multisine:offset=2.5,amplitude=0.5,lines=40,base=2,seed=1", "chirp:offset=2.5,amplitude=0.5,
/// from=0.1,to=20". Seeds default to `seed`. Only the form is checked here; Generate checks
/// the numbers.
Result<ExcitationSpec> ParseExcitation(std::string_view text, std::uint64_t seed);

}  // namespace faultlab::core
