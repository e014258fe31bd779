#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/diagnosis/diagnosis_options.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// The options of all commands that diagnose a recording.
struct DiagnosisFlags {
  std::string bench;             ///< FILE.toml; empty: the paper's
  std::string healthy;           ///< "from:to" in seconds, fault-free; empty: the bench's
  std::string channels = "all";  ///< "um" or "all"
  std::string values = "none";   ///< "table2": faults have values that the relays can connect
  std::string calibration;       ///< JSON of `calibrate`; empty: estimated from the record's start
};

struct DiagnoseCommandOptions {
  std::vector<std::string> files;  ///< files, or folders: all recordings in them, sorted by name
  DiagnosisFlags flags;
  bool json = false;
  std::string method;  ///< of core/methods, in place of faultlab's own diagnosis; empty: that one
};

/// For a record of this bench. Refuses by the option's name. Reads the calibration's file.
core::Result<core::DiagnosisOptions> ParseFlags(const DiagnosisFlags& flags,
                                                const core::Bench& bench);

/// Takes the period of the record, and the stretch that is usual at that period, counted from its
/// first row, unless the flags name one.
void FollowRecord(const DiagnosisFlags& flags,
                  std::span<const core::Sample> samples,
                  double period_s,
                  core::DiagnosisOptions& options);

/// Diagnoses each file, in order, and prints the result: text, or one JSON object per line. A file
/// that cannot be read is reported on stderr, and the other files are still diagnosed.
/// @returns kExitOk, whatever the verdicts are; kExitBadInput when a file or flag was refused
int RunDiagnose(const DiagnoseCommandOptions& options);

}  // namespace faultlab::server
