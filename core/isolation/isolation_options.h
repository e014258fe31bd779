#pragma once

#include "core/types/plant_parameters.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// Values that a component may take: what relays can connect, or anything positive.
enum class ValuePrior { kNone, kTable2 };

/// What the isolation may assume about the rig.
struct IsolationOptions {
  Channels channels = Channels::kAll;
  ValuePrior values = ValuePrior::kNone;
  bool motor_faults = true;  ///< false: Ra, J, B are not considered
  double period_s = kSamplePeriodSeconds;
  double um_rail_v = 10.0;
};

}  // namespace faultlab::core
