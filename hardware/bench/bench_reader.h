#pragma once

#include <string_view>

#include "core/bench/bench.h"
#include "core/types/result.h"

namespace faultlab::hardware {

/// A bench out of its TOML text. Every key is checked for kind and range, unknown ones are refused,
/// and so is what does not belong together. An Error's message begins "NAME:LINE: " and says what
/// was expected; its field is the dotted key.
core::Result<core::Bench> ReadBench(std::string_view text, std::string_view name);

}  // namespace faultlab::hardware
