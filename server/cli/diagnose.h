#pragma once

#include <string>
#include <vector>

#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/types/result.h"

namespace faultlab::server {

/// What the commands that diagnose a recording have in common.
struct DiagnosisFlags {
  std::string healthy = "0.5:5";  ///< "from:to" in seconds, fault-free
  std::string channels = "all";   ///< "um" or "all"
  std::string values = "none";    ///< "table2": faults have values that the relays can connect
  std::string calibration;        ///< JSON of `calibrate`; empty: learnt from the record's start
};

struct DiagnoseCommandOptions {
  std::vector<std::string> files;  ///< or folders: all recordings in them, by name
  DiagnosisFlags flags;
  bool json = false;
};

/// Refuses by the option's name. Reads the calibration's file.
core::Result<core::DiagnosisOptions> ParseFlags(const DiagnosisFlags& flags);

/// kInvalid when a stored calibration does not fit a record of this period.
core::Status CheckCalibration(const core::DiagnosisOptions& options, double period_s);

/// Diagnoses each file, in order, and prints the answer: text, or one JSON object a line. A file
/// that cannot be read is reported on stderr and the others go on.
/// @returns kExitOk whatever the verdicts are; kExitBadInput when any file or flag was refused.
int RunDiagnose(const DiagnoseCommandOptions& options);

}  // namespace faultlab::server
