#include "core/paper/path_outcome.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

/// A step whose number is nearer to its limit than this factor could have gone the other way.
constexpr double kClose = 2.0;

}  // namespace

std::string_view Name(PathOutcome outcome) {
  switch (outcome) {
    case PathOutcome::kNothing:
      return "";
    case PathOutcome::kAgrees:
      return "agrees";
    case PathOutcome::kUnknown:
      return "unknown";
    case PathOutcome::kSettling:
      return "settling";
    case PathOutcome::kClose:
      return "close";
    case PathOutcome::kWindow:
      return "window";
  }
  return "";
}

bool IsClose(const PathStep& step) {
  if (!std::isfinite(step.value) || !std::isfinite(step.threshold) || step.threshold == 0.0) {
    return false;
  }
  const double times = std::abs(step.value / step.threshold);
  return times > 1.0 / kClose && times < kClose;
}

PathOutcome ComparePath(const Verdict& verdict) {
  if (verdict.path.empty()) return PathOutcome::kNothing;
  const std::vector<Component>& end = verdict.path.back().components;
  if (verdict.kind == VerdictKind::kUnknownFault) {
    return end.empty() ? PathOutcome::kNothing : PathOutcome::kUnknown;
  }
  if (verdict.kind != VerdictKind::kFault) return PathOutcome::kNothing;
  const std::vector<Component> named = NamedBy(verdict);
  if (named.empty()) return PathOutcome::kNothing;
  const bool shared = std::ranges::any_of(
      end, [&](Component one) { return std::ranges::find(named, one) != named.end(); });
  if (shared) return PathOutcome::kAgrees;
  if (!verdict.settled) return PathOutcome::kSettling;
  return std::ranges::any_of(verdict.path, IsClose) ? PathOutcome::kClose : PathOutcome::kWindow;
}

}  // namespace faultlab::core
