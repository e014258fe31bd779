#include "server/experiment/waiting_line.h"

#include <algorithm>

namespace faultlab::server {

std::list<WaitingLine::Waiting>& WaitingLine::LineOf(const std::string& bench, MonotonicTime now) {
  std::list<Waiting>& line = lines_[bench];
  line.remove_if([now](const Waiting& each) { return now > each.until + kKeptFor; });
  return line;
}

std::size_t WaitingLine::Ask(const std::string& bench,
                             const std::string& caller,
                             MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  std::list<Waiting>& line = LineOf(bench, now);
  const auto found = std::ranges::find(line, caller, &Waiting::caller);
  const auto before = static_cast<std::size_t>(
      std::count_if(line.begin(), found, [now](const Waiting& each) { return now <= each.until; }));
  const MonotonicTime until = now + 3 * AgainAfter(before);
  if (found != line.end()) {
    found->until = until;
  } else if (line.size() < kLongest) {
    line.push_back({caller, until});
  }
  return before;
}

void WaitingLine::Leave(const std::string& bench, const std::string& caller) {
  const std::lock_guard lock(mutex_);
  lines_[bench].remove_if([&](const Waiting& each) { return each.caller == caller; });
}

std::size_t WaitingLine::Length(const std::string& bench, MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(std::ranges::count_if(
      LineOf(bench, now), [now](const Waiting& each) { return now <= each.until; }));
}

}  // namespace faultlab::server
