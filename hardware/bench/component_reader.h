#pragma once

#include "core/bench/bench.h"
#include "hardware/config/toml_table.h"

namespace faultlab::hardware {

/// The [[component]] tables of a description into bench.parts. What does not belong together is
/// refused: a parameter that two components change, a line or a value that stands twice, a value
/// outside the component's range.
/// Contract: bench.structure and bench.nominal are read.
void ReadComponents(TomlTable& root, core::Bench& bench);

}  // namespace faultlab::hardware
