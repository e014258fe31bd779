#pragma once

#include "core/bench/bench.h"
#include "hardware/config/toml_table.h"

namespace faultlab::hardware {

/// The [channel.uc], um, ua, ia and n tables of a description. The channel by which the structure
/// is estimated must be there. Contract: bench.structure is read.
void ReadChannels(TomlTable& root, core::Bench& bench);

}  // namespace faultlab::hardware
