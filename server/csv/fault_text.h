#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/fault.h"
#include "core/types/result.h"

namespace faultlab::server {

/// "R1=100@10" abrupt, "R9=18000@5..17" drift from 5 s to 17 s, "R1=100@5to8" only from 5 s to 8 s.
/// The component is one of `bench`; values in SI units, a letter p n u m k M may follow:
/// "R12=5.6k@10".
core::Result<core::Fault> ParseFault(std::string_view text, const core::Bench& bench);

/// The shortest text that ParseFault converts back to the same fault.
std::string FormatFault(const core::Fault& fault);

/// A fault that was injected, as a comment of a CSV file: "fault R1=100@10".
std::string FaultComment(const core::Fault& fault);

/// The faults in the comments of a file; other comments and components that `bench` does not have
/// are skipped.
std::vector<core::Fault> FaultsInComments(const std::vector<std::string>& comments,
                                          const core::Bench& bench);

}  // namespace faultlab::server
