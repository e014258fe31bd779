#include "server/cli/console.h"

#include <cstdio>
#include <string>

#include "server/csv/bench_comment.h"
#include "server/csv/file_io.h"

namespace faultlab::server {

void PrintError(std::string_view message) {
  const std::string line = "faultlab: " + std::string(message) + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);
}

int Fail(const core::Error& error, int exit_code) {
  PrintError(error.message);
  return exit_code;
}

int Fail(const core::Error& error) {
  const bool ours =
      error.code == core::ErrorCode::kUnavailable || error.code == core::ErrorCode::kBusy;
  return Fail(error, ours ? kExitFailure : kExitBadInput);
}

void NoteOtherBench(const std::string& file,
                    const NamedBench& named,
                    const std::string& bench_option,
                    const core::Bench& read_as) {
  const std::string note = NoteOnOtherBench(file, named, read_as);
  if (!note.empty()) PrintError("note: " + note + (bench_option.empty() ? ": give --bench" : ""));
}

void PrintNotes(std::span<const std::string> notes) {
  for (const std::string& note : notes) PrintError("note: " + note);
}

int Print(std::string_view text) {
  return Ended(WriteFile("-", text));
}

int Ended(const core::Status& written) {
  return written ? kExitOk : Fail(written.error(), kExitFailure);
}

std::string_view Version() {
  return FAULTLAB_VERSION;
}

}  // namespace faultlab::server
