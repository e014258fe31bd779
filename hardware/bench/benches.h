#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"

namespace faultlab::hardware {

/// The bench that ships with faultlab: benches/paper.toml.
const core::Bench& PaperBench();

/// One of its simulators; an empty name is the usual one. kNotFound names what there is.
core::Result<const core::BenchProfile*> FindProfile(const core::Bench& bench,
                                                    std::string_view name);

/// No description is longer, and a process keeps no more of them.
inline constexpr std::size_t kBenchTextBytesMax = 64 * 1024;
inline constexpr std::size_t kBenchesMax = 1000;

/// The bench of this text, read once and kept until the process ends: components and options refer
/// to it without owning it. Texts that say the same are one bench, with the first one's text. A
/// laboratory has a few; kUnavailable when kBenchesMax are kept. Thread-safe, as all of this file.
core::Result<const core::Bench*> KeepBench(std::string_view text, std::string_view name);
/// Of a file, or of a shipped bench by its name ("servo-motor"); empty is PaperBench().
core::Result<const core::Bench*> LoadBench(const std::string& path);
/// All that ship with faultlab, the paper's first.
std::vector<const core::Bench*> LoadShippedBenches();
/// The kept bench with this Bench::id; nullptr when none has it.
const core::Bench* FindKeptBench(std::string_view id);

}  // namespace faultlab::hardware
