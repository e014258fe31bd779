#include "server/report/path_outcome.h"

#include <algorithm>
#include <cmath>

namespace faultlab::server {
namespace {

/// A step whose number is nearer to its limit than this factor could have gone the other way.
constexpr double kClose = 2.0;

}  // namespace

std::vector<std::string> NamedBy(const core::Verdict& verdict) {
  std::vector<std::string> names;
  std::vector<core::Component> group = verdict.group;
  std::ranges::sort(group, core::ByIndex{});
  for (const core::Component component : group) names.emplace_back(core::Name(component));
  if (names.empty() && !verdict.candidates.empty()) {
    names.emplace_back(core::Name(verdict.candidates.front().component));
  }
  return names;
}

bool IsClose(const core::PathStep& step) {
  if (!std::isfinite(step.value) || !std::isfinite(step.threshold) || step.threshold == 0.0) {
    return false;
  }
  const double times = std::abs(step.value / step.threshold);
  return times > 1.0 / kClose && times < kClose;
}

std::vector<std::string> PathEnd(const std::vector<core::PathStep>& path,
                                 const core::Bench& bench) {
  std::vector<std::string> names;
  if (path.empty()) return names;
  std::string word;
  const auto take = [&] {
    if (bench.Find(word)) names.push_back(word);
    word.clear();
  };
  for (const char c : path.back().leads_to) {
    if (c == ' ' || c == ',' || c == '/') {
      take();
    } else {
      word += c;
    }
  }
  take();
  return names;
}

PathOutcome ComparePath(const core::Verdict& verdict, const core::Bench& bench) {
  const std::vector<std::string> end = PathEnd(verdict.path, bench);
  if (verdict.path.empty()) return PathOutcome::kNothing;
  if (verdict.kind == core::VerdictKind::kUnknownFault) {
    return end.empty() ? PathOutcome::kNothing : PathOutcome::kUnknown;
  }
  if (verdict.kind != core::VerdictKind::kFault) return PathOutcome::kNothing;
  const std::vector<std::string> named = NamedBy(verdict);
  const bool shared = std::ranges::any_of(
      end, [&](const auto& name) { return std::ranges::find(named, name) != named.end(); });
  if (named.empty()) return PathOutcome::kNothing;
  if (shared) return PathOutcome::kAgrees;
  if (!verdict.settled) return PathOutcome::kSettling;
  return std::ranges::any_of(verdict.path, IsClose) ? PathOutcome::kClose : PathOutcome::kWindow;
}

}  // namespace faultlab::server
