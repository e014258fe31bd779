#include "server/csv/bench_comment.h"

#include <string_view>

namespace faultlab::server {
namespace {

constexpr std::string_view kMark = "bench ";
constexpr std::string_view kIdMark = ", id ";

}  // namespace

std::string BenchComment(const core::Bench& bench) {
  return std::string(kMark) + bench.name + std::string(kIdMark) + bench.id;
}

NamedBench BenchInComments(const std::vector<std::string>& comments) {
  for (const std::string& comment : comments) {
    if (!comment.starts_with(kMark)) continue;
    const std::string name = comment.substr(kMark.size(), comment.find(',') - kMark.size());
    // A sentence that begins with "bench" names none.
    const bool is_name = !name.empty() && name.find(' ') == std::string::npos;
    if (!is_name) continue;
    const std::size_t mark = comment.find(kIdMark);
    if (mark == std::string::npos) return {name, ""};
    const std::size_t from = mark + kIdMark.size();
    return {name, comment.substr(from, comment.find(',', from) - from)};
  }
  return {};
}

std::string NoteOnOtherBench(const std::string& file,
                             const NamedBench& named,
                             const core::Bench& read_as) {
  if (named.name.empty()) return "";
  if (named.name != read_as.name) {
    return file + " is of bench " + named.name + ", it is read as " + read_as.name;
  }
  if (named.id.empty() || named.id == read_as.id) return "";
  return file + " was made when bench " + named.name + " was described otherwise (" + named.id +
         "), it is read as " + read_as.id;
}

}  // namespace faultlab::server
