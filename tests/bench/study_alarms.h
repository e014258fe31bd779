#pragma once

#include "tests/bench/study_settings.h"

namespace faultlab::study {

/// Healthy rigs, every one calibrated on its own first seconds.
struct AlarmCount {
  double hours = 0.0;
  int rigs = 0;
  int alarms = 0;
  int refused = 0;  ///< rigs whose calibration was refused
};

AlarmCount CountFalseAlarms(const Settings& settings, bool um_only);

}  // namespace faultlab::study
