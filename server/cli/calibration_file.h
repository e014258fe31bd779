#pragma once

#include <string>

#include "core/types/calibration.h"
#include "core/types/result.h"

namespace faultlab::server {

/// Reads what `faultlab calibrate` wrote, or an answer of `diagnose --json`.
core::Result<core::Calibration> ReadCalibrationFile(const std::string& path);

}  // namespace faultlab::server
