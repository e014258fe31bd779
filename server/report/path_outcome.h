#pragma once

#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/verdict.h"

namespace faultlab::server {

/// The components of the verdict: those that no sensor tells apart, in the order of the
/// bench, otherwise the best one.
std::vector<std::string> NamedBy(const core::Verdict& verdict);
/// A step whose number is so near to its limit that it could have gone the other way.
bool IsClose(const core::PathStep& step);
/// The components at the end of the paper's path; empty for none.
std::vector<std::string> PathEnd(const std::vector<core::PathStep>& path, const core::Bench& bench);

/// Why the path ends elsewhere than the verdict, as far as the data show it.
enum class PathOutcome { kNothing, kAgrees, kUnknown, kSettling, kClose, kWindow };
PathOutcome ComparePath(const core::Verdict& verdict, const core::Bench& bench);

}  // namespace faultlab::server
