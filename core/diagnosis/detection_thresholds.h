#pragma once

#include "core/diagnosis/calibration.h"

namespace faultlab::core {

/// Alarm levels at which the whole bank raises `false_alarms_per_day` on a healthy rig.
/// From simulation of the bank itself (see detection_thresholds.cc), widened for a calibration that
/// rests on `calibration_samples` samples only. `mask`: channels in use.
DetectionThresholds MakeThresholds(double false_alarms_per_day,
                                   double rate_hz,
                                   unsigned mask,
                                   int calibration_samples);

}  // namespace faultlab::core
