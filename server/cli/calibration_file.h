#pragma once

#include <string>

#include "core/bench/bench.h"
#include "core/types/calibration.h"
#include "core/types/result.h"

namespace faultlab::server {

/// Reads the output of `faultlab calibrate` or of `diagnose --json`.
core::Result<core::Calibration> ReadCalibrationFile(const std::string& path,
                                                    const core::Bench& bench);

/// As ReadCalibrationFile reads it, with the name of the bench.
core::Status WriteCalibrationFile(const std::string& path,
                                  const core::Calibration& calibration,
                                  const core::Bench& bench);

}  // namespace faultlab::server
