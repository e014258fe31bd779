#pragma once

#include <string>
#include <vector>

#include "core/bench/bench.h"

namespace faultlab::server {

/// "bench gear-motor": the beginning of the comment by which a file names its bench; more may
/// follow after a comma.
std::string BenchComment(const core::Bench& bench);

/// The name of the bench in the comments of a file; empty when they name none.
std::string BenchInComments(const std::vector<std::string>& comments);

/// "FILE is of bench gear-motor, it is read as paper: give --bench"; empty when the file names no
/// bench, or the one that it is read as.
std::string NoteOnOtherBench(const std::string& file,
                             const std::string& named,
                             const core::Bench& read_as);

}  // namespace faultlab::server
