#pragma once

#include <string>
#include <string_view>

#include "server/storage/recording_store.h"

namespace faultlab::server {

/// The name of a file of this run: when, what, kind. "2026-11-21_0102_R1-=-100_samples.csv"; a run
/// without a name is called by its rig and its first fault: "2026-11-21_0102_sim-1_R1_signals.png".
/// Hidden faults are not named. The time is UTC.
std::string FileNameOf(const RunRecord& record, std::string_view kind, std::string_view extension);
/// The same of something else, begun `at`, that is called `what`.
std::string FileNameOf(WallTime at,
                       std::string_view what,
                       std::string_view kind,
                       std::string_view extension);

}  // namespace faultlab::server
