#pragma once

#include <vector>

#include "core/bench/bench.h"
#include "core/filter/rig_parameters.h"
#include "core/types/component.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// One fault of a set that is to be judged.
struct FaultSize {
  Component component{};
  double value = 1.0;  ///< SI unit of the component, > 0
};

/// The conditions under which a fault set is judged: a rig, an input, its noise, and the time
/// allowed.
struct IsolabilityOptions {
  const Bench* bench = nullptr;  ///< whose components are judged; never null
  RigParameters rig;             ///< healthy
  NoiseLevel noise;              ///< of the readings, and the friction's slow part
  Channels channels = Channels::kUmOnly;
  std::vector<double> uc_v;  ///< input; the fault begins at the start of the last `window_samples`
  int window_samples = 100;  ///< samples of the fault that may be used, 1 .. uc_v.size() - 10
  double period_s = 0.01;
  double false_alarms_per_day = 1.0;    ///< of one test that runs at every sample
  double detection_probability = 0.9;   ///< at which a fault is "visible", (0.5, 1)
  double confusion_probability = 0.01;  ///< below which two faults are distinguished
  std::vector<FaultSize> faults;        ///< empty: FaultsOf(bench)
};

}  // namespace faultlab::core
