#pragma once

#include "core/bench/bench.h"
#include "hardware/config/toml_table.h"

namespace faultlab::hardware {

/// The table [published] of a description, if it is there. Its faults are values that components
/// list in their `published`.
/// Contract: bench.parts are read.
void ReadPublication(TomlTable& root, core::Bench& bench);

}  // namespace faultlab::hardware
