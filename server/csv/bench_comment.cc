#include "server/csv/bench_comment.h"

#include <string_view>

namespace faultlab::server {
namespace {

constexpr std::string_view kMark = "bench ";

}  // namespace

std::string BenchComment(const core::Bench& bench) {
  return std::string(kMark) + bench.name;
}

std::string BenchInComments(const std::vector<std::string>& comments) {
  for (const std::string& comment : comments) {
    if (!comment.starts_with(kMark)) continue;
    const std::string name = comment.substr(kMark.size(), comment.find(',') - kMark.size());
    // A sentence that begins with "bench" names none.
    const bool is_name = !name.empty() && name.find(' ') == std::string::npos;
    if (is_name) return name;
  }
  return "";
}

std::string NoteOnOtherBench(const std::string& file,
                             const std::string& named,
                             const core::Bench& read_as) {
  if (named.empty() || named == read_as.name) return "";
  return file + " is of bench " + named + ", it is read as " + read_as.name + ": give --bench";
}

}  // namespace faultlab::server
