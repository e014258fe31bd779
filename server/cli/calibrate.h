#pragma once

#include <string>

#include "server/cli/diagnose.h"

namespace faultlab::server {

struct CalibrateOptions {
  std::string recording;  ///< CSV file
  std::string output;     ///< FILE.json; empty: only the text is printed
  std::string dated;      ///< free text; empty: now, ISO 8601 UTC
  double false_alarms_per_day = 1.0;
  DiagnosisFlags flags;
};

/// Calibrates a rig on the fault-free stretch of a recording and stores the result for
/// `--calibration`. If the stretch is refused, ends with kExitBadInput and the check that failed;
/// nothing is written.
int RunCalibrate(const CalibrateOptions& options);

}  // namespace faultlab::server
