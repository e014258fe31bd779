#pragma once

#include <string>
#include <vector>

#include "core/bench/bench.h"

namespace faultlab::server {

/// "bench gear-motor, id gear-motor-080d7355026d": the beginning of the comment by which a file
/// names its bench; more may follow after a comma.
std::string BenchComment(const core::Bench& bench);

/// The bench of a file; empty texts where it says none.
struct NamedBench {
  std::string name;
  std::string id;
};
NamedBench BenchInComments(const std::vector<std::string>& comments);

/// "FILE is of bench gear-motor, it is read as paper", or that the bench of this name was described
/// otherwise then; empty when the file names no bench, or the one that it is read as.
std::string NoteOnOtherBench(const std::string& file,
                             const NamedBench& named,
                             const core::Bench& read_as);

}  // namespace faultlab::server
