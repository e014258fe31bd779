#pragma once

#include <string_view>

#include "core/types/verdict.h"

namespace faultlab::core {

/// How the end of the paper's path (Fig. 21) compares with the verdict. Where it ends elsewhere,
/// why, as far as the data show it.
enum class PathOutcome {
  kNothing,   ///< nothing to compare
  kAgrees,    ///< a component at its end is in the verdict
  kUnknown,   ///< it knows single faults only, and no single component explains the record
  kSettling,  ///< the window after the fault is not full
  kClose,     ///< a step was close to its limit
  kWindow,    ///< it uses one window, and does not know which faults look alike
};

/// "" for kNothing, otherwise "agrees", "unknown", "settling", "close" or "window".
std::string_view Name(PathOutcome outcome);

/// A step whose number is so near to its limit that it could have gone the other way.
bool IsClose(const PathStep& step);

PathOutcome ComparePath(const Verdict& verdict);

}  // namespace faultlab::core
