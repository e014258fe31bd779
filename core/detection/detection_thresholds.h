#pragma once

#include "core/types/calibration.h"

namespace faultlab::core {

/// Alarm levels at which the whole bank raises `false_alarms_per_day` on a healthy rig whose noise
/// is known; the detector raises them according to the readings in its calibration. They come from
/// a simulation of the bank itself (see detection_thresholds.cc). `mask`: channels in use. Levels
/// are in the units of Detector::Statistics: standard deviations, nats, and twice nats.
DetectionThresholds MakeThresholds(double false_alarms_per_day, double rate_hz, unsigned mask);

}  // namespace faultlab::core
