#pragma once

#include "core/bench/bench.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// The values that a component may take: those that relays can connect (kTable2), or any positive
/// value.
enum class ValuePrior { kNone, kTable2 };

/// What the isolation may assume about the rig.
struct IsolationOptions {
  const Bench* bench = nullptr;  ///< whose components may have changed; never null
  Channels channels = Channels::kAll;
  ValuePrior values = ValuePrior::kNone;
  bool motor_faults = true;  ///< false: parts without relays are not considered
  double period_s = 0.01;
  double um_rail_v = 10.0;
};

}  // namespace faultlab::core
