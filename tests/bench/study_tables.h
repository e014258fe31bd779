#pragma once

#include <cstdio>
#include <span>

#include "core/isolability/isolability.h"
#include "tests/bench/study_settings.h"

namespace faultlab::study {

/// One row for each fault, with both sets of channels. @param relative_value  see RunTrial
void PrintFaultTable(std::FILE* out,
                     const Settings& settings,
                     std::span<const core::FaultSize> faults,
                     bool relative_value);

/// One row for each case, with all of the paper's faults in it.
void PrintRobustness(std::FILE* out, const Settings& settings);

}  // namespace faultlab::study
