#pragma once

#include <string>

namespace faultlab::server {

struct BenchCheckOptions {
  std::string bench;             ///< FILE.toml
  std::string channels = "all";  ///< or "um"
};

/// Describes a bench and what can be diagnosed on it, before anybody builds it: what its usual
/// excitation does to a healthy rig, which faults are visible within a second of it, which look
/// alike, the smallest visible fault, the expected errors of values. A description that is refused
/// ends with kExitBadInput and file, line, key and what was expected; one whose usual run could not
/// be made, or not be learned from, with kExitFailure.
int RunBenchCheck(const BenchCheckOptions& options);

}  // namespace faultlab::server
