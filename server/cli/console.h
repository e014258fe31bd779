#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>

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
/// kExitFailure where a disk, a database or a rig does not do its part, else kExitBadInput.
int Fail(const core::Error& error);
/// "faultlab: note: .." on stderr, when a file names another bench than it is read as, or another
/// description of it.
void NoteOtherBench(const std::string& file,
                    const NamedBench& named,
                    const std::string& bench_option,
                    const core::Bench& read_as);
/// TRY and TRY_DONE of a subcommand: what is refused is printed, and the status is kExitBadInput.
#define TRY_INPUT(declaration, ...) \
  TRY_INPUT_AS(LAB_JOINED(tried_, __COUNTER__), declaration, __VA_ARGS__)
#define TRY_INPUT_AS(result, declaration, ...)                  \
  auto&& result = (__VA_ARGS__);                                \
  if (!result.ok()) return Fail(result.error(), kExitBadInput); \
  declaration = std::forward<decltype(result)>(result).value()
#define TRY_INPUT_DONE(...) \
  if (auto&& tried = (__VA_ARGS__); !tried.ok()) return Fail(tried.error(), kExitBadInput)
/// "faultlab: note: .." on stderr, each in a line.
void PrintNotes(std::span<const std::string> notes);
/// Writes to the standard output at once; kExitFailure when not all of it could be written.
int Print(std::string_view text);
/// The end of a command that has written a file: kExitOk, or kExitFailure with the error printed.
int Ended(const core::Status& written);

/// "0.1.0"
std::string_view Version();

}  // namespace faultlab::server
