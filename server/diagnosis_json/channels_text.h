#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"

namespace faultlab::server {

/// "um" (the voltage alone) or "all". Refuses (kInvalid, field "channels") other words, and um on
/// a bench that does not measure it.
core::Result<core::Channels> ParseChannels(std::string_view text, const core::Bench& bench);

/// A note for each column of a record that a diagnosis on this bench does not use, because its
/// description names no such channel. `columns`: "um_v"; `file` begins each note.
std::vector<std::string> NotesOnUnused(std::span<const std::string> columns,
                                       const core::Bench& bench,
                                       std::string_view file);

}  // namespace faultlab::server
