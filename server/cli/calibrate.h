#pragma once

#include <string>

#include "server/cli/diagnose.h"

namespace faultlab::server {

struct CalibrateOptions {
  std::string recording;  ///< CSV file
  std::string output;     ///< FILE.json; empty: only the text
  std::string dated;      ///< free text; empty: now, ISO 8601 UTC
  double false_alarms_per_day = 1.0;
  DiagnosisFlags flags;
};

/// Learns a rig from the fault-free stretch of a recording and stores it for `--calibration`.
/// A stretch that is refused ends in kExitBadInput with the check that failed; nothing is written.
int RunCalibrate(const CalibrateOptions& options);

}  // namespace faultlab::server
