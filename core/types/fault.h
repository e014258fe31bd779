#pragma once

#include <string_view>

#include "core/types/component.h"

namespace faultlab::core {

enum class FaultKind {
  kAbrupt,        ///< jumps to `value` at `at_s`
  kDrift,         ///< linear from nominal at `at_s` to `value` at `until_s`, then stays
  kIntermittent,  ///< `value` during [at_s, until_s), nominal again after
};

/// "abrupt", "drift", "intermittent"
constexpr std::string_view Name(FaultKind kind) {
  switch (kind) {
    case FaultKind::kAbrupt:
      return "abrupt";
    case FaultKind::kDrift:
      return "drift";
    case FaultKind::kIntermittent:
      return "intermittent";
  }
  return "?";
}

/// One scheduled change of a component. A fault acts from the first sample whose time is >= at_s.
struct Fault {
  Component component{};
  double value = 1.0;  ///< SI unit of the component, > 0
  double at_s = 10.0;
  FaultKind kind = FaultKind::kAbrupt;
  double until_s = 0.0;  ///< end of drift or of the interval; unused for kAbrupt
};

}  // namespace faultlab::core
