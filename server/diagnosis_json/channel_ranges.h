#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// Compares what a record has with what the channels of the bench can read: a file in other units,
/// or of another quantity, would pass as a healthy record. 95 of 100 readings of a column decide.
/// A column that is a little beyond its range gives a note, one that is ten times beyond it a
/// refusal (kInvalid, field is the column); both name the unit that would fit.
core::Result<std::vector<std::string>> NotesOnRanges(std::span<const core::Sample> samples,
                                                     const core::Bench& bench,
                                                     std::string_view file);

}  // namespace faultlab::server
