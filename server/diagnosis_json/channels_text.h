#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// "um" (the voltage alone) or "all". Refuses (kInvalid, field "channels") other words, and um on
/// a bench that does not measure it.
core::Result<core::Channels> ParseChannels(std::string_view text, const core::Bench& bench);

/// Of a record with these columns ("um_v") on this bench: notes on what is not used and on what is
/// beyond its range (NotesOnRanges). Refuses (kInvalid, field is the column) a record without the
/// channel by which the bench is diagnosed, and what NotesOnRanges refuses. `file` begins each.
core::Result<std::vector<std::string>> NotesOnRecord(std::span<const std::string> columns,
                                                     std::span<const core::Sample> samples,
                                                     const core::Bench& bench,
                                                     std::string_view file);

/// A note for each column of a record that a diagnosis on this bench does not use, because its
/// description names no such channel. `columns`: "um_v"; `file` begins each note.
std::vector<std::string> NotesOnUnused(std::span<const std::string> columns,
                                       const core::Bench& bench,
                                       std::string_view file);

}  // namespace faultlab::server
