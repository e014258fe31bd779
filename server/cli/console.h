#pragma once

#include <string>
#include <string_view>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "server/csv/bench_comment.h"

namespace faultlab::server {

/// The exit status of a subcommand.
inline constexpr int kExitOk = 0;
inline constexpr int kExitFailure = 1;   ///< an output could not be written, a part is missing
inline constexpr int kExitBadInput = 2;  ///< an option, a file or a value is wrong; stderr names it

/// "faultlab: message" on stderr.
void PrintError(std::string_view message);
/// Prints the error and returns `exit_code`.
int Fail(const core::Error& error, int exit_code);
/// "faultlab: note: .." on stderr, when a file names another bench than it is read as, or another
/// description of it.
void NoteOtherBench(const std::string& file,
                    const NamedBench& named,
                    const std::string& bench_option,
                    const core::Bench& read_as);
/// Writes to the standard output at once; kExitFailure when not all of it could be written.
int Print(std::string_view text);

/// "0.1.0"
std::string_view Version();

}  // namespace faultlab::server
